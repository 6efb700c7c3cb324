//! Accuracy on data of worse and worse condition.

use super::{HORIZON, ORDER, Outcome, drive, fit, model, row, truth, white};
use std::path::Path;
use steerwright_evaluation::peers::{Peers, write_signals};
use steerwright_evaluation::{Random, markov_distance};
use steerwright_sysid::subspace::Factor;
use steerwright_sysid::{StateSpace, Weighting};

/// Inputs of less and less power at high frequencies.
pub(crate) fn ill_conditioned(path: &Path, mut peers: Option<&mut Peers>) -> Outcome<()> {
    const COUNT: usize = 20_000;
    const CASES: [(usize, f64); 9] = [
        (0, 1e-3),
        (3, 1e-3),
        (0, 1e-7),
        (4, 1e-8),
        (6, 1e-8),
        (9, 1e-11),
        (12, 1e-11),
        (4, 0.0),
        (9, 0.0),
    ];
    println!(
        "\nIll-conditioned data: white noise through so many low-pass filters as input, N = {COUNT}; MOESP"
    );
    println!(
        "| filters | noise | factor by | horizon | Markov parameters off here | SLICOT, QR | SLICOT, Cholesky | fit here, % | fit SLICOT QR, % |"
    );
    println!("|---|---|---|---|---|---|---|---|---|");
    let truth = truth();
    for (filters, noise) in CASES {
        let mut random = Random(99);
        let mut u = white(COUNT, &mut random);
        for _ in 0..filters {
            let (mut last, mut state) = (0.0, 0.0);
            for x in &mut u {
                // (1 + z⁻¹)/(1 − 0.6 z⁻¹)/5: nothing is left at the highest frequency.
                state = 0.6 * state + 0.2 * (*x + last);
                last = *x;
                *x = state;
            }
        }
        let signals = drive(u, noise, &mut random);
        write_signals(path, &signals.u, &signals.y)?;
        let off = |m: &StateSpace| markov_distance(&truth, m, 30);
        let mut cells = vec!["–".to_string(); 3];
        if let Some(peers) = peers.as_deref_mut() {
            peers.load(path, COUNT)?;
            for (k, algorithm) in ['Q', 'C'].into_iter().enumerate() {
                match peers.slicot(HORIZON, ORDER, algorithm, 1) {
                    Ok(found) => {
                        cells[k] = format!("{:.1e}", off(&found.model.model));
                        if k == 0 {
                            cells[2] = format!("{:.4}", fit(&found.model.model, &signals));
                        }
                    }
                    Err(problem) => cells[k] = problem,
                }
            }
        }
        let factor = Factor::of_signals(&[(row(&signals.u), row(&signals.y))], HORIZON, 1.0);
        match factor.and_then(|f| model(&f, Weighting::Moesp).map(|m| (f, m))) {
            Ok((factor, found)) => println!(
                "| {filters} | {noise:e} | {} | {} | {:.1e} | {} | {} | {:.4} | {} |",
                factor.conditioning,
                factor.horizon,
                off(&found.model),
                cells[0],
                cells[1],
                fit(&found.model, &signals),
                cells[2]
            ),
            Err(problem) => println!(
                "| {filters} | {noise:e} | {problem} | | | {} | {} | | {} |",
                cells[0], cells[1], cells[2]
            ),
        }
    }
    Ok(())
}
