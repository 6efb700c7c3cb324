//! How much memory this process has, and tests that need a process for themselves.

use std::process::Command;

/// Bytes of memory that this process has resident; 0 where Linux does not report it.
pub(crate) fn resident() -> usize {
    let Ok(text) = std::fs::read_to_string("/proc/self/statm") else { return 0 };
    // Pages; their size is 4096 where these tests run, and a factor does not matter to "flat".
    text.split_whitespace().nth(1).and_then(|word| word.parse().ok()).map_or(0, |n: usize| n * 4096)
}

/// Runs a test in a process of its own, where nothing else takes memory. In the first process it
/// gives true, and the test has nothing more to do.
pub(crate) fn runs_alone(test: &str) -> bool {
    const ALONE: &str = "STEERWRIGHT_TEST_ALONE";
    if std::env::var_os(ALONE).is_some() {
        return false;
    }
    let status = Command::new(std::env::current_exe().unwrap())
        .args(["--exact", test, "--include-ignored", "--nocapture", "--test-threads=1"])
        .env(ALONE, "1")
        .status()
        .unwrap();
    assert!(status.success(), "{test}, alone: {status}");
    true
}
