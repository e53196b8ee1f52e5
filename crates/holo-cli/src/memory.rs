//! The allocator of the C library, and the end of a process without memory.

/// The size from which a block of memory is one of the system's own, bytes.
#[cfg(all(target_os = "linux", target_env = "gnu"))]
const LARGE: libc::c_int = 1 << 20;

/// The free memory that a region of smaller blocks keeps, bytes. By default it is 128 KB, and every small image that is
/// encoded gives its memory back to the system and gets it again: 400 files took 1.7 to 2.6 times as long.
#[cfg(all(target_os = "linux", target_env = "gnu"))]
const KEPT: libc::c_int = 16 << 20;

/// Makes blocks of a megabyte and more go back to the system when they are freed. By default glibc raises this size to 32 MB
/// as a program frees larger blocks, and keeps them in regions of the threads that freed them, so that a process with many
/// jobs would need more memory than any of the jobs. Does nothing with other C libraries, or where the
/// environment sets the size.
pub fn return_large_blocks() {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    if std::env::var_os("MALLOC_MMAP_THRESHOLD_").is_none() {
        // SAFETY: `mallopt` sets numbers of the allocator, before this program starts threads.
        unsafe {
            libc::mallopt(libc::M_MMAP_THRESHOLD, LARGE);
            libc::mallopt(libc::M_TRIM_THRESHOLD, KEPT);
        }
    }
}

/// Makes the process end with a message and exit code 1 where it would abort: Rust and C++ do so if they get no memory and
/// cannot report it. Files that are being written keep their temporary names, and the next command in the folder removes
/// them. Does nothing on other systems than Unix.
pub fn report_aborts() {
    #[cfg(unix)]
    {
        extern "C" fn end(_: libc::c_int) {
            const MESSAGE: &[u8] = b"holo: stopped: out of memory, or a fault of a library; \
                make the images smaller, or raise --memory-gb\n";
            // SAFETY: both functions may be called in a handler of signals, and the message is as long as it says.
            unsafe {
                libc::write(libc::STDERR_FILENO, MESSAGE.as_ptr().cast(), MESSAGE.len());
                libc::_exit(1);
            }
        }
        // SAFETY: the handler has the signature that `signal` asks for, and calls nothing that a handler must not call.
        unsafe {
            libc::signal(libc::SIGABRT, end as extern "C" fn(libc::c_int) as libc::sighandler_t);
        }
    }
}
