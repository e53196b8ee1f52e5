//! `holo preview`: it prints its address, ends at a signal, and its page works in a browser, where there is one.

use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Command, Stdio};

use crate::common::{Bench, SCENE, peer};

/// A preview that runs until this is dropped.
struct Running {
    child: std::process::Child,
    address: String,
}

impl Running {
    fn new(bench: &Bench, arguments: &str) -> Self {
        let mut command = bench.command(&format!("preview {arguments} --no-open"));
        let mut child = command.stdout(Stdio::piped()).stderr(Stdio::null()).spawn().unwrap();
        let mut address = String::new();
        BufReader::new(child.stdout.take().unwrap()).read_line(&mut address).unwrap();
        Self { child, address: address.trim().to_owned() }
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

#[test]
fn the_address_is_printed_and_wrong_scenes_are_refused() {
    let bench = Bench::new();
    let running = Running::new(&bench, SCENE);
    let rest = running.address.strip_prefix("http://127.0.0.1:").unwrap_or_else(|| panic!("{}", running.address));
    let (port, token) = rest.split_once("/?token=").unwrap();
    assert!(port.parse::<u16>().unwrap() > 0 && token.len() == 32, "{rest}");
    // The port is taken.
    let second = bench.run(&format!("preview {SCENE} --no-open --port {port}"));
    assert!(second.code == Some(1) && second.stderr.contains("choose another port"), "{second:?}");
    for (arguments, words) in [("missing.glb", "missing.glb"), ("/dev/null", "/dev/null")] {
        let refused = bench.run(&format!("preview {arguments} --no-open"));
        assert!(refused.code == Some(1) && refused.stderr.contains(words), "{refused:?}");
    }
    // A mirrored pose is none.
    let mirrored = r#"{"fl_x": 30, "frames": [{"file_path": "a.png",
        "transform_matrix": [[-1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]}]}"#;
    std::fs::write(bench.path("mirrored.json"), mirrored).unwrap();
    let refused = bench.run(&format!("preview {SCENE} --no-open --transforms mirrored.json"));
    assert!(refused.code == Some(1) && refused.stderr.contains("mirrored.json: camera 'a'"), "{refused:?}");
    // Nothing is written before a render.
    assert!(!bench.path("holo-preview").exists());
}

/// Set `HOLO_SHOTS` to a folder to keep screenshots of the page.
#[test]
fn a_browser_uses_the_page() {
    let bench = Bench::new();
    std::fs::write(bench.path("garden.glb"), holo_scene::gallery::to_glb("garden").unwrap().unwrap()).unwrap();
    let placed = "array plane --count 2x1 --spacing-m 0.3 --radius-m 1.2 --size 96x64 --fov-deg 40 --seed 1 --jitter-rotation-deg 5";
    assert_eq!(bench.run(&format!("{placed} --out poses.json")).code, Some(0));
    let running = Running::new(&bench, "garden.glb --preset draft --transforms poses.json");
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/preview/check.py");
    let mut command = Command::new("python3");
    command.arg(script).arg(&running.address).arg(bench.path(SCENE));
    if let Some(shots) = std::env::var_os("HOLO_SHOTS") {
        command.arg("--shots").arg(shots);
    }
    match command.output() {
        Ok(output) if output.status.code() == Some(77) => peer::missing("chromium (HOLO_CHROMIUM names it)"),
        Ok(output) => {
            let said = String::from_utf8_lossy(&output.stdout);
            assert!(output.status.success(), "{said}{}", String::from_utf8_lossy(&output.stderr));
            println!("{said}");
        }
        Err(why) => peer::missing(&format!("python3: {why}")),
    }
}
