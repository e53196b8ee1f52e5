//! Requests of the page and of others.

use super::*;

/// Runs `work` with a server that may not write, and stops it.
fn with_server(work: impl FnOnce(&Server)) {
    with(Preview::new().bind(0).unwrap(), work);
}

fn with(server: Server, work: impl FnOnce(&Server)) {
    let stop = AtomicBool::new(false);
    std::thread::scope(|scope| {
        let (server, stop) = (&server, &stop);
        scope.spawn(move || server.run(stop).unwrap());
        let done = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| work(server)));
        stop.store(true, Ordering::SeqCst);
        done.unwrap();
    });
}

/// The answer to the bytes of a request.
fn answer(server: &Server, request: &str) -> String {
    let mut stream = TcpStream::connect(server.address).unwrap();
    stream.set_read_timeout(Some(Duration::from_secs(10))).unwrap();
    stream.write_all(request.as_bytes()).unwrap();
    let mut out = Vec::new();
    // A socket stays open.
    let mut part = [0; 4096];
    while let Ok(count) = stream.read(&mut part) {
        out.extend_from_slice(&part[..count]);
        if count == 0 || out.starts_with(b"HTTP/1.1 101") {
            break;
        }
    }
    String::from_utf8_lossy(&out).into_owned()
}

fn get(server: &Server, path: &str, host: &str, more: &str) -> String {
    answer(server, &format!("GET {path} HTTP/1.1\r\nHost: {host}\r\n{more}\r\n"))
}

const UPGRADE: &str = "Connection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\n\
                       Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n";

#[test]
fn the_page_needs_token_and_host() {
    with_server(|server| {
        let host = server.address.to_string();
        let (token, port) = (server.token.clone(), server.address.port());
        let page = get(server, &format!("/?token={token}"), &host, "");
        assert!(page.starts_with("HTTP/1.1 200") && page.contains("<!DOCTYPE html>"), "{page}");
        assert!(page.contains("Content-Security-Policy: default-src 'none'; script-src 'self'"), "{page}");
        assert!(page.contains(&format!("/preview.js?token={token}")), "{page}");
        let localhost = format!("localhost:{port}");
        for path in ["/preview.js", "/preview.css"] {
            let found = get(server, &format!("{path}?token={token}"), &localhost, "");
            assert!(found.starts_with("HTTP/1.1 200"), "{path}: {found}");
        }
        let rebound = format!("attacker.example:{port}");
        for (path, host) in [
            ("/", host.as_str()),
            ("/?token=", &host),
            ("/?token=00000000000000000000000000000000", &host),
            (&format!("/?token={token}0"), &host),
            (&format!("/?token={token}"), &rebound),
            (&format!("/preview.js?token={token}"), &rebound),
        ] {
            let refused = get(server, path, host, "");
            assert!(refused.starts_with("HTTP/1.1 403") && !refused.contains(&token), "{path} {host}: {refused}");
        }
        let missing = get(server, &format!("/view/0?token={token}"), &host, "");
        assert!(missing.starts_with("HTTP/1.1 404"), "{missing}");
        let outside = get(server, &format!("/view/../../etc/passwd?token={token}"), &host, "");
        assert!(outside.starts_with("HTTP/1.1 404"), "{outside}");
    });
}

#[test]
fn other_computers_name_the_server_by_an_address() {
    for (listen, own, others) in [
        ("127.0.0.1", vec!["127.0.0.1", "localhost"], vec!["192.168.1.5", "a.example", "[::1]"]),
        ("0.0.0.0", vec!["127.0.0.1", "localhost", "192.168.1.5"], vec!["a.example", "192.168.1.5.a.example"]),
    ] {
        let server = Preview::new().listen(listen.parse().unwrap()).bind(0).unwrap();
        let port = server.address.port();
        assert!(own.iter().all(|host| server.is_own(&format!("{host}:{port}"))), "{listen}");
        assert!(others.iter().all(|host| !server.is_own(&format!("{host}:{port}"))), "{listen}");
        assert!(!server.is_own(own[0]) && !server.is_own(&format!("{}:{}", own[0], port ^ 1)), "{listen}");
    }
}

#[test]
fn the_socket_needs_the_origin_of_the_page() {
    with_server(|server| {
        let host = server.address.to_string();
        let path = format!("/socket?token={}", server.token);
        let own = format!("{UPGRADE}Origin: http://{host}\r\n");
        assert!(get(server, &path, &host, &own).starts_with("HTTP/1.1 101"));
        for origin in ["", "Origin: http://attacker.example\r\n", "Origin: null\r\n", "Origin: https://127.0.0.1\r\n"] {
            let refused = get(server, &path, &host, &format!("{UPGRADE}{origin}"));
            assert!(refused.starts_with("HTTP/1.1 403"), "{origin}: {refused}");
        }
        let refused = get(server, "/socket?token=wrong", &host, &own);
        assert!(refused.starts_with("HTTP/1.1 403"), "{refused}");
    });
}

#[test]
fn what_is_no_request_is_refused() {
    with_server(|server| {
        for request in ["\r\n\r\n", "GET\r\n\r\n", &format!("GET / HTTP/1.1\r\nX: {}\r\n\r\n", "a".repeat(20_000))] {
            let refused = answer(server, request);
            assert!(refused.is_empty() || refused.starts_with("HTTP/1.1 4"), "{refused}");
        }
    });
}

/// A page, as a browser would open it.
type Page = tungstenite::WebSocket<TcpStream>;

fn open(server: &Server) -> Page {
    use tungstenite::client::IntoClientRequest;
    let host = server.address.to_string();
    let mut request = format!("ws://{host}/socket?token={}", server.token).into_client_request().unwrap();
    request.headers_mut().insert("Origin", format!("http://{host}").parse().unwrap());
    let stream = TcpStream::connect(server.address).unwrap();
    stream.set_read_timeout(Some(Duration::from_secs(60))).unwrap();
    tungstenite::client(request, stream).unwrap().0
}

/// The next message: header and bytes.
fn receive(page: &mut Page) -> (serde_json::Value, Vec<u8>) {
    loop {
        if let tungstenite::Message::Binary(bytes) = page.read().unwrap() {
            let length = u32::from_le_bytes(bytes[..4].try_into().unwrap()) as usize;
            let header = serde_json::from_slice(&bytes[4..4 + length]).unwrap();
            return (header, bytes[4 + length..].to_vec());
        }
    }
}

/// All messages up to one of this kind.
fn until(page: &mut Page, kind: &str) -> Vec<(serde_json::Value, Vec<u8>)> {
    let mut all = Vec::new();
    loop {
        all.push(receive(page));
        if all.last().unwrap().0["kind"] == kind {
            return all;
        }
    }
}

fn send(page: &mut Page, message: &serde_json::Value) {
    page.send(tungstenite::Message::text(message.to_string())).unwrap();
}

fn look(kind: &str, number: u64, moving: bool) -> serde_json::Value {
    serde_json::json!({
        "kind": kind,
        "number": number,
        "scene": "plaster",
        "settings": {"views": "3", "lenses": "24x16", "spp": "1", "disparity": "-1,1"},
        "size": [96, 96],
        "moving": moving,
    })
}

#[test]
fn a_page_sees_a_scene_and_renders_it() {
    let out = tempfile::tempdir().unwrap();
    let server = Preview::new().out(out.path().to_owned()).bind(0).unwrap();
    with(server, |server| {
        let mut page = open(server);
        assert_eq!(receive(&mut page).0["kind"], "hello");
        send(&mut page, &look("look", 1, false));
        let messages = until(&mut page, "settled");
        let of = |kind: &str| messages.iter().filter(move |(header, _)| header["kind"] == kind).collect::<Vec<_>>();
        let views = of("view");
        let (first, last) = (views[0], views[views.len() - 1]);
        // 24 x 16 pixels fit into 96 x 96 as 96 x 64.
        let decoded = image::load_from_memory(&first.1).unwrap();
        assert_eq!((decoded.width(), decoded.height()), (96, 64));
        assert!(first.0["samples"] == 1 && last.0["samples"].as_u64().unwrap() >= 4, "{views:?}");
        let (details, depth) = of("details")[0];
        assert_eq!(details["lenses"], serde_json::json!([24, 16]));
        let depth: Vec<f32> =
            depth.chunks_exact(4).map(|bytes| f32::from_le_bytes(bytes.try_into().unwrap())).collect();
        assert_eq!(depth.len(), 24 * 16);
        // The disparities of the settings, by Eq. 3 as the page has it.
        let number = |key: &str| details[key].as_f64().unwrap();
        let scale = details["scale_m_px"][0].as_f64().unwrap();
        let of_depth = |depth: f32| scale * (1.0 / f64::from(depth) - number("inverse_focus_per_m"));
        let range = depth.iter().filter(|depth| depth.is_finite()).map(|depth| of_depth(*depth));
        let (low, high) = range.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), d| (low.min(d), high.max(d)));
        assert!((low + 1.0).abs() < 1e-3 && (high - 1.0).abs() < 1e-3, "{low} {high}");
        assert!(details["estimate"]["seconds"].as_f64().unwrap() > 0.0);
        let command = details["command"].as_str().unwrap();
        assert!(command.contains("holo render plaster.glb --out plaster --disparity -1,1"), "{command}");
        let strip = image::load_from_memory(&of("strip")[0].1).unwrap();
        assert_eq!((strip.width(), strip.height()), (24 * 3, 16 * 3));

        send(&mut page, &look("look", 2, true));
        let (view, _) = receive(&mut page);
        assert_eq!((&view["kind"], &view["moving"], &view["number"]), (&"view".into(), &true.into(), &2.into()));

        send(&mut page, &look("render", 3, false));
        let draft = until(&mut page, "rendered").pop().unwrap().0;
        let full = until(&mut page, "rendered").pop().unwrap().0;
        assert_eq!((&draft["stage"], &full["stage"]), (&"draft".into(), &"full".into()));
        assert!(out.path().join("plaster_001/full/manifest.json").is_file());
        let path = format!("{}?token={}", full["path"].as_str().unwrap(), server.token);
        let shown = get(server, &path, &server.address.to_string(), "");
        assert!(shown.starts_with("HTTP/1.1 200") && shown.contains("<!DOCTYPE html>"));
    });
}

#[test]
fn wrong_messages_are_told_and_the_page_goes_on() {
    with_server(|server| {
        let mut page = open(server);
        let changed = |number: u64, change: &dyn Fn(&mut serde_json::Value)| {
            let mut changed = look("look", number, true);
            change(&mut changed);
            changed
        };
        for (message, words) in [
            (serde_json::json!({"kind": "open", "path": "/etc/passwd"}), "no message"),
            (changed(1, &|look| look["scene"] = "../../etc/passwd".into()), "no scene"),
            (changed(2, &|look| look["camera"] = "/etc/passwd".into()), "no camera"),
            (changed(3, &|look| look["settings"]["sky"] = "/etc/secret.exr".into()), "environment map"),
            (changed(4, &|look| look["settings"]["views"] = "0".into()), "views"),
            (look("render", 5, false), "may not write"),
        ] {
            send(&mut page, &message);
            let told = loop {
                let (header, _) = receive(&mut page);
                if header["kind"] == "error" || header["kind"] == "ended" {
                    break header["text"].as_str().unwrap().to_owned();
                }
            };
            assert!(told.contains(words), "{message}: {told}");
        }
        send(&mut page, &look("look", 6, true));
        assert_eq!(until(&mut page, "view").pop().unwrap().0["number"], 6);
        // A scene that is none, then one that is dropped.
        send(&mut page, &serde_json::json!({"kind": "drop", "name": "bad.glb"}));
        page.send(tungstenite::Message::binary(vec![1, 2, 3])).unwrap();
        send(&mut page, &changed(7, &|look| look["scene"] = "".into()));
        assert!(until(&mut page, "error").pop().unwrap().0["text"].as_str().unwrap().contains("bad.glb"));
        send(&mut page, &serde_json::json!({"kind": "drop", "name": "good.glb"}));
        let glb = holo_scene::gallery::to_glb("chess").unwrap().unwrap();
        page.send(tungstenite::Message::binary(glb)).unwrap();
        send(&mut page, &changed(8, &|look| look["scene"] = "".into()));
        let messages = until(&mut page, "view");
        assert!(
            messages.iter().any(|(header, _)| header["kind"] == "scene" && header["name"] == "good"),
            "{messages:?}"
        );
    });
}

/// The scene that a page begins with is loaded before the page is opened, and only once.
#[test]
fn the_first_scene_is_loaded_ahead() {
    let scene = holo_dataset::SceneSource::gallery("plaster").unwrap();
    let mut given = holo_dataset::settings::Given::default();
    given.insert("views", "3").unwrap();
    with(Preview::new().scene(scene).given(given).bind(0).unwrap(), |server| {
        let mut page = open(server);
        let told = until(&mut page, "scene");
        assert_eq!(told.iter().map(|(header, _)| header["kind"].clone()).collect::<Vec<_>>(), ["hello", "scene"]);
        for number in 1..3 {
            let mut wanted = look("look", number, true);
            wanted["scene"] = "".into();
            wanted["settings"]["fov-deg"] = "50".into();
            send(&mut page, &wanted);
            let (first, _) = receive(&mut page);
            assert_eq!((&first["kind"], &first["number"]), (&"view".into(), &number.into()));
        }
        // Another one is loaded as it is wanted, and pages that are opened later have studios of their own.
        send(&mut page, &look("look", 3, true));
        assert_eq!(receive(&mut page).0["kind"], "scene");
        let mut other = open(server);
        assert_eq!(receive(&mut other).0["kind"], "hello");
        send(&mut other, &look("look", 4, true));
        assert_eq!(receive(&mut other).0["kind"], "scene");
    });
}

/// A camera of microlenses of 14 px.
fn small_camera(width: u32, height: u32) -> holo_io::CameraFile {
    let camera = format!(
        "[sensor]\nsize_px = [{width}, {height}]\npixel_um = 5.0\n[mla]\ngrid = \"square\"\npitch_um = 71.2\n\
         gap_um = 400.0\n[main_lens]\nfocal_mm = 40.0\nf_number = 5.8\nfocus_m = 0.8\n"
    );
    holo_io::CameraFile::parse(&camera, "small").unwrap()
}

#[test]
fn a_plenoptic_camera_shows_its_raw_and_white_image() {
    let server = Preview::new().camera(small_camera(60, 45)).bind(0).unwrap();
    with(server, |server| {
        let mut page = open(server);
        let mut wanted = look("look", 1, false);
        wanted["camera"] = "own".into();
        send(&mut page, &wanted);
        let messages = until(&mut page, "settled");
        let of = |kind: &str| messages.iter().find(|(header, _)| header["kind"] == kind).unwrap();
        for kind in ["strip", "white"] {
            let decoded = image::load_from_memory(&of(kind).1).unwrap();
            assert_eq!((decoded.width(), decoded.height()), (60, 45), "{kind}");
        }
        let share = of("white").0["lit_share"].as_f64().unwrap();
        assert!(share > 0.4 && share <= 1.0, "{share}");
        assert!(of("details").0["command"].as_str().unwrap().contains("--camera-file small.toml"));
    });
}

/// Draft and full render of a plenoptic camera are raw images, whose views the viewer shows.
#[test]
fn the_views_of_a_plenoptic_camera_are_shown() {
    let out = tempfile::tempdir().unwrap();
    let server = Preview::new().camera(small_camera(210, 160)).out(out.path().to_owned()).bind(0).unwrap();
    with(server, |server| {
        let mut page = open(server);
        let mut wanted = look("render", 1, false);
        wanted["camera"] = "own".into();
        send(&mut page, &wanted);
        for stage in ["draft", "full"] {
            let rendered = until(&mut page, "rendered").pop().unwrap().0;
            assert_eq!(rendered["stage"], stage);
            let path = format!("{}?token={}", rendered["path"].as_str().unwrap(), server.token);
            let shown = get(server, &path, &server.address.to_string(), "");
            assert!(shown.starts_with("HTTP/1.1 200") && shown.contains("<!DOCTYPE html>"), "{stage}");
            assert!(out.path().join("plaster_001").join(stage).join("raw.exr").is_file());
        }
    });
}
