//! The energy of microfacets.

use std::f64::consts::PI;

use brewster_tests::{Shot, assert_stokes, pixel, scene};

use crate::elements::{SURROUNDINGS, degrees, plate};

/// Share of light that a rough surface of lossless facets reflects in one bounce, by quadrature over facet normals.
///
/// ∫ G1(i) G1(o) D(m) (o·m)/cos o dm over facets that mirror the view above the surface: GGX, Smith shadowing.
///
/// Source: Walter et al., Microfacet Models for Refraction through Rough Surfaces, EGSR 2007, Eqs. (20), (33), (34).
fn single_scattering_albedo(alpha: f64, cos_o: f64) -> f64 {
    let sin_o = (1.0 - cos_o * cos_o).sqrt();
    let shadowing =
        |cos: f64| 2.0 / (1.0 + (1.0 + alpha * alpha * (1.0 / (cos * cos) - 1.0)).sqrt());
    let (steps, turns) = (2000, 720);
    let mut sum = 0.0;
    for j in 0..steps {
        // by slope: tan² = α² u/(1 - u) has the density D cos of facets for uniform u
        let u = (f64::from(j) + 0.5) / f64::from(steps);
        let tan2 = alpha * alpha * u / (1.0 - u);
        let cos_m = 1.0 / (1.0 + tan2).sqrt();
        let sin_m = (1.0 - cos_m * cos_m).sqrt();
        for turn in 0..turns {
            let phi = (f64::from(turn) + 0.5) / f64::from(turns) * PI;
            let o_m = sin_o * sin_m * phi.cos() + cos_o * cos_m;
            let cos_i = 2.0 * o_m * cos_m - cos_o;
            if o_m > 0.0 && cos_i > 0.0 {
                sum += shadowing(cos_i) * shadowing(cos_o) * o_m / (cos_o * cos_m);
            }
        }
    }
    sum / f64::from(steps * turns)
}

#[test]
fn rough_lossless_metal_loses_only_what_meets_a_second_facet() {
    for (alpha, angle) in [(0.1, 0.0), (0.3, 40.0), (0.5, 60.0), (0.5, 80.0)] {
        let (sin, cos) = degrees(angle).sin_cos();
        let bsdf = format!(
            "<bsdf type='roughconductor'><string name='distribution' value='ggx'/><float name='alpha' value='{alpha}'/></bsdf>"
        );
        let text = scene(
            2,
            &format!("origin='{sin}, 0, {cos}' target='0, 0, 0' up='0, 1, 0'"),
            0.01,
            &format!("{SURROUNDINGS}{}", plate(&bsdf, "<scale value='9'/>")),
        );
        let found = pixel(&Shot::new(100_000).of_text(&text), 0, 0, 0);
        let albedo = single_scattering_albedo(alpha, cos);
        assert!(albedo > 0.6 && albedo < 1.0 + 1e-6);
        // the midpoint rule: doubling its points changes the fifth digit
        assert_stokes(
            &format!("alpha {alpha}, {angle} degrees"),
            found,
            [albedo, 0.0, 0.0, 0.0],
            3e-5,
        );
    }
}
