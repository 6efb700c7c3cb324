//! A whole road with its speed profile: all units in one package, from standstill to standstill.

use crate::support::{chain, column, document, done, package_whole_road};
use steerwright_formats::Path as PathFile;
use steerwright_host::SystemPackage;
use steerwright_models::SpeedReference;

#[test]
fn a_package_of_all_units_drives_the_road_from_standstill_to_standstill() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    package_whole_road(folder, &chain().join("bicycle.json"));
    let package = SystemPackage::open(folder.join("fmu/WholeRoad.ssp")).unwrap();
    let structure = package.structure();
    let names: Vec<&str> = structure.components.iter().map(|c| c.name.as_str()).collect();
    let expected = [
        "LongitudinalPlant",
        "BicyclePlant",
        "PoseEstimator",
        "ReferencePath",
        "SpeedController",
        "LateralPid",
    ];
    let mut sorted = names.clone();
    sorted.sort_unstable();
    let mut all = expected;
    all.sort_unstable();
    assert_eq!(sorted, all);
    assert_eq!(names[..4], expected[..4], "{names:?}");
    let path: PathFile = document(&folder.join("path.json"));
    let profile = path.profile.as_ref().unwrap();
    let time = profile.time_s;
    let stop = structure.stop_time.unwrap();
    assert!(stop > time && stop < time + 10.0, "{stop} {time}");
    // The plants start at the beginning of the profile, which is a standstill.
    for archive in package.archives() {
        let initial = archive.model().variable("initial_speed").map(|v| v.start.clone().unwrap());
        assert!(initial.is_none_or(|speed| speed == 0.0.into()));
    }

    let due = SpeedReference::new(profile, false);
    let length = path.points.last().unwrap().distance_m;
    for coupling in ["gauss-seidel", "jacobi"] {
        done(folder, &format!("simulate fmu/WholeRoad.ssp -o run.csv --coupling {coupling}"));
        let read = |name: &str| column(&folder.join("run.csv"), name);
        let speed = read("LongitudinalPlant.speed");
        let distance = read("ReferencePath.distance");
        let errors = read("ReferencePath.cross_track_error");
        // The units' reference is that of a place ahead.
        let off = |(v, s): (&f64, &f64)| (v - due.at(*s)[0]).powi(2);
        let squares: f64 = speed.iter().zip(&distance).map(off).sum();
        let rms = (squares / speed.len() as f64).sqrt();
        let largest = speed.iter().copied().fold(0.0, f64::max);
        let lateral = errors.iter().map(|e| e.abs()).fold(0.0, f64::max);
        let end = distance.last().unwrap();
        println!(
            "{coupling}: {rms:.3} m/s RMS, up to {largest:.2} m/s, {lateral:.3} m off the road at most, stands {:.2} m \
             before its end",
            length - end
        );
        assert_eq!((speed[0], *speed.last().unwrap()), (0.0, 0.0));
        assert!(rms < 0.3 && largest > 15.0, "{rms} {largest}");
        assert!(lateral < 0.1, "{lateral}");
        assert!((length - end).abs() < 0.5, "{end} of {length}");
        assert!(*read("SpeedController.holding").last().unwrap() == 1.0);
    }
}
