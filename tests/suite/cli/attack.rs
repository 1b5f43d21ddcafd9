//! A short run of `tests/examples/attack.rs`: every verb, every kind of attack.

use std::path::Path;
use std::time::Duration;

use texmap_tests::attack::attack;

#[test]
fn spoilt_inputs_special_files_and_signals_do_no_harm() {
    let program = Path::new(env!("CARGO_BIN_EXE_texmap-tested"));
    // Ten seconds are the aim, measured by the example; a suite may run beside anything.
    let minute = Duration::from_secs(60);
    let summary = attack(program, 29, 0..150, minute, |finding| {
        eprintln!("{finding}");
    })
    .unwrap();
    assert!(summary.findings.is_empty(), "{summary}");
    // The cases reach the program: they end in every way.
    for code in [0, 2, 4] {
        assert!(summary.codes.contains_key(&code), "{summary}");
    }
}
