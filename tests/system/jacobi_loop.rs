//! A design for a Jacobi coupling, in the loop of its FMUs under that coupling: path and estimator delay it
//! by two and three communication steps, which the design includes.

use crate::support::{chain, column, document, run, text_of};
use std::path::Path;
use steerwright_control::PlantModel;
use steerwright_formats::{LoopCoupling, Path as PathFile, Pid, Plant};

/// Long, so that the delays of a step or three show.
const SAMPLE_TIME: &str = "40ms";

fn done(folder: &Path, line: &str) {
    let output = run(folder, line);
    assert_ne!(output.status.code(), Some(2), "{line}: {}", text_of(&output));
}

/// RMS distance of the vehicle from the road, m, by its true position.
fn cross_track(road: &PathFile, csv: &Path) -> f64 {
    let geometry = steerwright_models::files::path_geometry(road).unwrap();
    let [x, y] = ["IdentifiedPlant.x", "IdentifiedPlant.y"].map(|name| column(csv, name));
    let (mut at, mut squares) = (road.points[0].distance_m, 0.0);
    for (x, y) in x.iter().zip(&y) {
        let foot = geometry.project(*x, *y, at);
        at = foot.foot.distance_m;
        squares += foot.cross_track_error.powi(2);
    }
    (squares / x.len() as f64).sqrt()
}

/// Designs for a coupling and drives the road under Jacobi, without and with the estimator: RMS of the
/// cross-track error, m.
fn driven(folder: &Path, designed_for: &str) -> [f64; 2] {
    let design = format!("design {{chain}}/plant.json --pid-sample-time {SAMPLE_TIME}");
    done(folder, &format!("{design} --coupling {designed_for} -o pid.json"));
    done(folder, "path --pid pid.json -o path.json");
    let road: PathFile = document(&folder.join("path.json"));
    ["", "{data}/multibody/estimator.json"].map(|estimator| {
        done(
            folder,
            &format!("package {{chain}}/plant.json pid.json path.json {estimator} --ssp L.ssp"),
        );
        done(folder, "simulate L.ssp --coupling jacobi -o result.csv");
        if estimator.is_empty() {
            as_predicted(folder, &road);
        }
        let rms = cross_track(&road, &folder.join("result.csv"));
        println!("designed for {designed_for}, {estimator}: {rms:.4} m");
        rms
    })
}

/// The FMUs do what the design's own loop does.
fn as_predicted(folder: &Path, road: &PathFile) {
    let plant: Plant = document(&chain().join("plant.json"));
    let pid: Pid = document(&folder.join("pid.json"));
    let [time, y, steering] = ["time", "IdentifiedPlant.y", "LateralPid.steering_angle"]
        .map(|name| column(&folder.join("result.csv"), name));
    let model = PlantModel::from_plant(&plant).unwrap();
    let stop = time[time.len() - 1];
    let predicted =
        steerwright_control::track(model, &pid, road, stop, LoopCoupling::Jacobi).unwrap();
    assert_eq!(predicted.y.len(), y.len());
    for (ours, theirs) in [(&predicted.y, &y), (&predicted.steering, &steering)] {
        let apart = ours.iter().zip(theirs).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(apart < 1e-9, "{apart}");
    }
}

#[test]
fn a_design_with_the_delays_of_path_and_estimator_tracks_under_jacobi() {
    let folder = tempfile::tempdir().unwrap();
    let [path, estimator] = driven(folder.path(), "jacobi");
    let [path_unaware, estimator_unaware] = driven(folder.path(), "gauss-seidel");
    assert!(path < 0.04 && estimator < 0.04, "{path} {estimator}");
    assert!(path_unaware > 2.0 * path, "{path_unaware} {path}");
    assert!(estimator_unaware > 2.0 * estimator, "{estimator_unaware} {estimator}");
}
