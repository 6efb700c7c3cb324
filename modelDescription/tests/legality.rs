//! The tables of section 2.2.7 of FMI 2.0.5, copied letter by letter, against the functions.

use model_description::{
    Causality, Initial, Variability, allows_start, default_initial, is_legal, needs_start,
};

/// Columns: parameter, calculatedParameter, input, output, local, independent.
/// A: exact. B: calculated (default), approx. C: calculated (default), exact, approx.
/// D: input. E: independent.
const STANDARD: [(Variability, &str); 5] = [
    (Variability::Constant, "---AA-"),
    (Variability::Fixed, "AB--B-"),
    (Variability::Tunable, "AB--B-"),
    (Variability::Discrete, "--DCC-"),
    (Variability::Continuous, "--DCCE"),
];

#[test]
fn every_combination_is_as_in_the_standard() {
    for (variability, row) in STANDARD {
        for (&causality, group) in Causality::ALL.iter().zip(row.chars()) {
            let (default, possible): (Option<Initial>, &[Initial]) = match group {
                'A' => (Some(Initial::Exact), &[Initial::Exact]),
                'B' => (Some(Initial::Calculated), &[Initial::Approx, Initial::Calculated]),
                'C' => (Some(Initial::Calculated), Initial::ALL),
                _ => (None, &[]),
            };
            let place = format!("{causality}, {variability}");
            assert_eq!(is_legal(causality, variability, None), group != '-', "{place}");
            for &initial in Initial::ALL {
                let legal = is_legal(causality, variability, Some(initial));
                assert_eq!(legal, possible.contains(&initial), "{place}, {initial}");
            }
            assert_eq!(default_initial(causality, variability), default, "{place}");
            if group != '-' {
                assert_eq!(needs_start(causality, default), matches!(group, 'A' | 'D'), "{place}");
            }
        }
    }
}

#[test]
fn start_values() {
    for &causality in Causality::ALL {
        for initial in [Initial::Exact, Initial::Approx] {
            assert!(needs_start(causality, Some(initial)));
        }
        assert!(!allows_start(causality, Some(Initial::Calculated)));
    }
    assert!(needs_start(Causality::Input, None));
    assert!(!allows_start(Causality::Independent, None));
    assert!(allows_start(Causality::Input, None));
}
