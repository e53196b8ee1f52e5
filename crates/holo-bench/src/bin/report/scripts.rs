//! The scripts of `crates/holo-bench/peers`, which drive other renderers.

use std::path::Path;
use std::process::{Command, Stdio};

/// Runs a script on a scene in the Python that `peer` was installed for. Its images are in a temporary folder, `--out`:
/// `read` gets what it printed before they are removed. Messages begin with the name of the program.
///
/// # Errors
/// If the program is not installed, or fails.
pub fn run<T>(
    peer: &str,
    script: &str,
    program: &str,
    scene: &Path,
    arguments: &[&str],
    read: impl FnOnce(&str) -> T,
) -> Result<T, String> {
    let peers = std::env::var_os("HOLO_PEERS").ok_or("the peers are not installed (cargo xtask report --peers)")?;
    let home = Path::new(&peers).join(peer);
    // Contains the path of the Python that the peer was installed for; written last during installation.
    let python = std::fs::read_to_string(home.with_extension("python"))
        .map_err(|_| format!("{program}: could not be installed"))?;
    let out = std::env::temp_dir().join(format!("holo-peers-{}", std::process::id()));
    std::fs::create_dir_all(&out).map_err(|why| format!("{}: {why}", out.display()))?;
    let output = Command::new(python.trim())
        .arg(Path::new(env!("CARGO_MANIFEST_DIR")).join("peers").join(script))
        .arg(scene)
        .arg("--out")
        .arg(&out)
        .args(arguments)
        .env("PYTHONPATH", &home)
        .stderr(Stdio::piped())
        .output()
        .map_err(|why| format!("{program}: {}: {why}", python.trim()));
    let found = output.map(|output| (read(&String::from_utf8_lossy(&output.stdout)), output));
    let _ = std::fs::remove_dir_all(&out);
    let (found, output) = found?;
    if output.status.success() {
        return Ok(found);
    }
    let message = String::from_utf8_lossy(&output.stderr);
    Err(format!("{program}: {}", message.lines().last().unwrap_or("no message")))
}
