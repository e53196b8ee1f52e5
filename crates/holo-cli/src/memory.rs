//! The allocator of the C library.

/// The size from which a block of memory is one of the system's own, bytes.
#[cfg(all(target_os = "linux", target_env = "gnu"))]
const LARGE: libc::c_int = 1 << 20;

/// Makes blocks of a megabyte and more go back to the system when they are freed. By default glibc raises this size to 32 MB
/// as a program frees larger blocks, and keeps them in regions of the threads that freed them, so that a process with many
/// jobs would need more memory than any of the jobs. Does nothing with other C libraries, or where the
/// environment sets the size.
pub fn return_large_blocks() {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    if std::env::var_os("MALLOC_MMAP_THRESHOLD_").is_none() {
        // SAFETY: `mallopt` sets a number of the allocator, before this program starts threads.
        unsafe {
            libc::mallopt(libc::M_MMAP_THRESHOLD, LARGE);
        }
    }
}
