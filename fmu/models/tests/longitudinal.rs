use steerwright_models::LongitudinalParameters;

#[test]
fn the_accelerator_is_that_whose_share_of_the_gain_acts() {
    for curvature in [-1.0, -0.5, -1e-9, 0.0, 0.3, 0.9, 1.0] {
        let parameters = LongitudinalParameters {
            pedal_curvature: curvature,
            ..LongitudinalParameters::default()
        };
        let mut before = -1.0;
        for k in 0..=200 {
            let share = 0.005 * f64::from(k);
            let accelerator = parameters.accelerator(share);
            let acting = parameters.share_of_gain(accelerator);
            assert!((acting - share).abs() < 1e-13, "{curvature} {share} {acting}");
            assert!(
                accelerator > before && accelerator <= 1.0,
                "{curvature} {share} {accelerator}"
            );
            before = accelerator;
        }
        assert_eq!(parameters.accelerator(-0.2), 0.0);
        assert_eq!(parameters.accelerator(1.7), 1.0);
        assert_eq!(parameters.share_of_gain(1.2), 1.2);
    }
}
