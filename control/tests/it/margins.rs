//! Margins against python-control's, `disk_margins` with zero skew among them
//! (data/margins_reference.py).

use crate::common::{designed, identified, options as usual};
use steerwright_control::{DesignOptions, DesignPlant, evaluate};

#[test]
fn margins_are_those_of_python_control() {
    let text = include_str!("data/margins_reference.csv");
    let mut lines = text.lines();
    let names: Vec<&str> = lines.next().expect("a header").split(',').collect();
    let mut cases = 0;
    for line in lines {
        let values: Vec<f64> = line.split(',').map(|v| v.parse().expect("a number")).collect();
        let of = |name: &str| {
            values[names.iter().position(|n| *n == name).expect("a column of that name")]
        };
        let (tau, ts) = (of("tau"), of("sample_time"));
        let file = identified(&[-1.0 / tau], &[of("gain") / tau], &[1.0], ts, of("late") * ts);
        let plant = DesignPlant::from_plant(&file).expect("a plant");
        let options = DesignOptions { sample_time_s: ts, robust: None, ..usual() };
        let mut pid = designed(&plant, &options);
        (pid.gains.kp, pid.gains.ki, pid.gains.kd) = (of("kp"), of("ki"), of("kd"));
        pid.gains.derivative_filter_time_s = of("filter");
        let margins = evaluate(&plant, &pid).expect("an evaluation").margins;
        for (name, reached) in [
            ("gain_margin_db", margins.gain_margin_db),
            ("phase_margin_deg", margins.phase_margin_deg),
            ("modulus", Some(margins.modulus_margin)),
            ("disk", margins.disk_margin),
        ] {
            let (reached, reference) = (reached.expect("a margin"), of(name));
            assert!((reached / reference - 1.0).abs() < 1e-5, "{name}: {reached} {reference}");
        }
        cases += 1;
    }
    assert_eq!(cases, 3);
}
