//! Run-time dispatch: the same code compiled for several instruction sets.
//!
//! This is one of the two files of this crate that contain `unsafe`. It calls a safe function that is compiled for
//! AVX2 or AVX-512 after it has checked that the processor supports that instruction set. The kernels are ordinary
//! loops over 16 lanes, which the compiler vectorizes for each set. The compiler does not contract multiplications and
//! additions into fused operations, so the results are bitwise identical on all sets. A program that is compiled for a
//! processor with AVX-512 anyway (`target-cpu=native`) has one version of each kernel. A debug build leaves AVX-512 to
//! the tests that compare the sets: the versions are a large part of the time of compiling.

/// Work that is compiled once per instruction set. Implementations mark `run`, and all hot functions that it calls,
/// `#[inline(always)]`: only code that is inlined into the entry point is compiled for its instruction set.
pub(crate) trait Kernel {
    type Output;
    fn run(self) -> Self::Output;
}

/// Runs `kernel` with the best instruction set of this processor.
#[inline]
pub(crate) fn run<K: Kernel>(kernel: K) -> K::Output {
    #[cfg(all(target_arch = "x86_64", not(target_feature = "avx512bw")))]
    {
        #[cfg(not(debug_assertions))]
        if std::arch::is_x86_feature_detected!("avx512f")
            && std::arch::is_x86_feature_detected!("avx512vl")
            && std::arch::is_x86_feature_detected!("avx512dq")
            && std::arch::is_x86_feature_detected!("avx512bw")
        {
            // SAFETY: the processor was just found to have these features.
            return unsafe { avx512(kernel) };
        }
        #[cfg(not(target_feature = "avx2"))]
        if std::arch::is_x86_feature_detected!("avx2") {
            // SAFETY: as above.
            return unsafe { avx2(kernel) };
        }
    }
    kernel.run()
}

#[cfg(all(target_arch = "x86_64", any(test, not(any(debug_assertions, target_feature = "avx512bw")))))]
#[target_feature(enable = "avx512f,avx512vl,avx512dq,avx512bw,avx2")]
fn avx512<K: Kernel>(kernel: K) -> K::Output {
    kernel.run()
}

#[cfg(all(target_arch = "x86_64", any(test, not(target_feature = "avx2"))))]
#[target_feature(enable = "avx2")]
fn avx2<K: Kernel>(kernel: K) -> K::Output {
    kernel.run()
}

/// Runs the kernel on every instruction set of this processor, slowest first: for tests that compare them.
#[cfg(test)]
pub(crate) fn run_on_all<K: Kernel>(mut kernel: impl FnMut() -> K) -> Vec<K::Output> {
    #[cfg_attr(not(target_arch = "x86_64"), allow(unused_mut, reason = "there is one set"))]
    let mut results = vec![kernel().run()];
    #[cfg(target_arch = "x86_64")]
    {
        if std::arch::is_x86_feature_detected!("avx2") {
            // SAFETY: the processor was just found to have it.
            results.push(unsafe { avx2(kernel()) });
        }
        if std::arch::is_x86_feature_detected!("avx512f")
            && std::arch::is_x86_feature_detected!("avx512vl")
            && std::arch::is_x86_feature_detected!("avx512dq")
            && std::arch::is_x86_feature_detected!("avx512bw")
        {
            // SAFETY: as above.
            results.push(unsafe { avx512(kernel()) });
        }
    }
    results
}
