//! The memory that a command may use.
//!
//! The system keeps the limit, so that it holds for everything that this process does: for our own tables, which are
//! refused with a message, and for Embree, HDF5 and the codecs. What a render allocates it reserves before it starts.

/// The limit without an option: this part of the memory that is free when the command starts.
#[cfg(target_os = "linux")]
const SHARE: f64 = 0.9;

/// Limits the memory that this process may use from now on, in addition to what it has, GB; `None`: nine tenths of what is
/// free. A limit that is lower already stays.
///
/// # Errors
/// A message if the system cannot limit itself so, and somebody asked for it.
#[cfg(target_os = "linux")]
pub fn limit(gigabytes: Option<f64>) -> Result<(), String> {
    use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};

    let Some(more) = gigabytes.map(|gigabytes| gigabytes * 1e9).or_else(|| free_bytes().map(|free| free * SHARE))
    else {
        return Ok(());
    };
    let Rlimit { current, maximum } = getrlimit(Resource::Data);
    let used = line_bytes("/proc/self/status", "VmData:").unwrap_or(0.0);
    // Floats become the nearest integer, however large.
    let wanted = (used + more) as u64;
    let allowed = [current, maximum].into_iter().flatten().fold(wanted, u64::min);
    let limited = setrlimit(Resource::Data, Rlimit { current: Some(allowed), maximum });
    match (limited, gigabytes) {
        (Err(why), Some(_)) => Err(format!("--memory-gb: the system does not limit the memory of this process: {why}")),
        _ => Ok(()),
    }
}

/// Limits nothing: other systems than Linux count address space, most of which is never used.
#[cfg(not(target_os = "linux"))]
pub fn limit(gigabytes: Option<f64>) -> Result<(), String> {
    match gigabytes {
        Some(_) => Err("--memory-gb needs Linux; remove it".into()),
        None => Ok(()),
    }
}

/// The memory that this process could get: of the machine with its swap, and of its control group (version 2).
#[cfg(target_os = "linux")]
fn free_bytes() -> Option<f64> {
    let machine = |key| line_bytes("/proc/meminfo", key);
    let machine = machine("MemAvailable:")? + machine("SwapFree:").unwrap_or(0.0);
    Some(group_bytes().map_or(machine, |group| group.min(machine)))
}

/// What the control group of this process has left. Cached files do not count, as they can go.
#[cfg(target_os = "linux")]
fn group_bytes() -> Option<f64> {
    let groups = std::fs::read_to_string("/proc/self/cgroup").ok()?;
    let own = groups.lines().find_map(|line| line.strip_prefix("0::"))?;
    let read = |name: &str| std::fs::read_to_string(format!("/sys/fs/cgroup{own}/{name}")).ok();
    let number = |text: &str| text.trim().parse::<f64>().ok();
    let (max, used) = (number(&read("memory.max")?)?, number(&read("memory.current")?)?);
    let cached = read("memory.stat")?.lines().find_map(|line| number(line.strip_prefix("file ")?))?;
    Some((max - used + cached).max(0.0))
}

/// The number of bytes in the line of a file that begins with a key, which the system gives in kilobytes.
pub fn line_bytes(path: &str, key: &str) -> Option<f64> {
    let text = std::fs::read_to_string(path).ok()?;
    let rest = text.lines().find_map(|line| line.strip_prefix(key))?;
    rest.trim().strip_suffix("kB")?.trim().parse::<f64>().ok().map(|kilobytes| kilobytes * 1024.0)
}
