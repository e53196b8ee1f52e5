//! The same code compiled for several instruction sets, chosen at run time.
//!
//! This is one of the two files of the project that contain `unsafe`: all it does is call a safe function that is
//! compiled for AVX2 or AVX-512 after asking the processor whether it has them. The kernels are ordinary loops over 16
//! lanes; the compiler vectorises them for each set. No set fuses multiplications with additions by itself, so the
//! results are the same bits everywhere.

/// Work that is compiled once per instruction set. Implementations mark `run` `#[inline(always)]`, and everything hot
/// beneath it too: only what is inlined into the entry is compiled for its instruction set.
pub(crate) trait Kernel {
    type Output;
    fn run(self) -> Self::Output;
}

/// Runs `kernel` with the best instruction set of this processor.
#[inline]
pub(crate) fn run<K: Kernel>(kernel: K) -> K::Output {
    #[cfg(target_arch = "x86_64")]
    {
        if std::arch::is_x86_feature_detected!("avx512f")
            && std::arch::is_x86_feature_detected!("avx512vl")
            && std::arch::is_x86_feature_detected!("avx512dq")
            && std::arch::is_x86_feature_detected!("avx512bw")
        {
            // SAFETY: the processor was just found to have these features.
            return unsafe { avx512(kernel) };
        }
        if std::arch::is_x86_feature_detected!("avx2") {
            // SAFETY: as above.
            return unsafe { avx2(kernel) };
        }
    }
    kernel.run()
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512vl,avx512dq,avx512bw,avx2")]
fn avx512<K: Kernel>(kernel: K) -> K::Output {
    kernel.run()
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn avx2<K: Kernel>(kernel: K) -> K::Output {
    kernel.run()
}

/// What the processor has, slowest first, for tests that hold the sets against each other.
#[cfg(test)]
pub(crate) fn run_on_all<K: Kernel>(mut kernel: impl FnMut() -> K) -> Vec<K::Output> {
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
