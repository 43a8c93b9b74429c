//! Random closed scenes: after a repair rows close, exchanges are mutual, and every factor is one.

mod common;

use common::*;
use etendue_radiosity::PatchSize;
use etendue_radiosity::form_factor::{Hemisphere, Method, Open, Pairs};
use proptest::prelude::*;

/// A room of some size, turned, with a ball or a box in it that touches no wall.
fn room() -> impl Strategy<Value = (String, f64)> {
    let size = (0.5..2.0f64, 0.5..2.0f64, 0.5..2.0f64);
    (size, 0.0..360.0f64, prop::bool::ANY, 0.1..0.5f64, 0.4..1.2f64).prop_map(|((x, y, z), angle, ball, inner, h)| {
        let turn = format!(r#"<rotate x="1" y="2" z="-1" angle="{angle}"/><translate x="3" y="-1"/>"#);
        let walls = shape("cube", &format!(r#"<scale x="{x}" y="{y}" z="{z}"/>{turn}"#), FLIPPED);
        let radius = inner * x.min(y).min(z);
        let model = if ball { "sphere" } else { "cube" };
        (walls + &shape(model, &format!(r#"<scale value="{radius}"/>{turn}"#), ""), h)
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, failure_persistence: None, rng_seed: proptest::test_runner::RngSeed::Fixed(4), ..ProptestConfig::default() })]

    #[test]
    fn repaired_factors_obey_physics((text, h) in room(), seed in 0..1000u64) {
        let scene = scene(&text);
        let patches = cut(&scene, PatchSize::Metres(h));
        let areas: Vec<f64> = patches.patches.iter().map(|p| p.area).collect();
        let rays = Method::Hemisphere(Hemisphere { rays: 512, seed, ..Hemisphere::default() });
        let closed_forms = Method::Analytic(Pairs { samples: 4096, seed });
        for method in [rays, closed_forms] {
            // Polygons alone are quick by closed forms.
            if matches!(method, Method::Analytic(_)) && (text.contains("sphere") || patches.len() > 200) {
                continue;
            }
            let mut f = method.run(&scene, &patches, &|_, _| true).expect("not cancelled");
            let told = f.repair(&areas, Open::WithLosses);
            prop_assert!(told.closed && told.closure_after <= 1e-12, "{told:?}");
            for i in 0..f.len() {
                prop_assert!((f.row_sum(i) - 1.0).abs() <= 1e-12);
                for (j, x) in f.row(i) {
                    prop_assert!((0.0..=1.0).contains(&x));
                    let back = areas[j] * f.get(j, i);
                    prop_assert!((areas[i] * x - back).abs() <= 1e-12 * back);
                }
            }
        }
    }
}
