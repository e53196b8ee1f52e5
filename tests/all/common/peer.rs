//! The treatment of tests whose peer, a program or a library for comparison, is missing.

/// Reports that a check does not run because `needs` is missing on this machine.
///
/// # Panics
///
/// If `HOLO_REQUIRE_PEERS` is 1, as `.ci/run` sets it for root: there a missing peer is a failure.
#[track_caller]
pub fn missing(needs: &str) {
    let is_required = std::env::var_os("HOLO_REQUIRE_PEERS").is_some_and(|value| value == "1");
    assert!(!is_required, "HOLO_REQUIRE_PEERS is 1, and this check needs {needs}");
    eprintln!("not run: needs {needs}");
}
