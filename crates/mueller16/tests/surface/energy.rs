//! Mirror and diffuse light of a rough surface together: all of the light, and never more with the cap.

use std::f64::consts::{FRAC_PI_2, PI};

use crate::relief::{PlainHeights, direction, green, heights};
use mueller16::{Boundary, Passage, RayFrames, Surface, SurfaceError};
use mueller16::{GaussianHeights, Geometry, IncidentCoherence, Relief, Superposed, Tolerance};

/// Of the quadrature in these tests, relative.
const QUADRATURE: f64 = 1e-5;

fn to(relative: f64) -> Tolerance {
    Tolerance::relative(relative).unwrap()
}

/// `e^(−g) + diffuse` for a perfect boundary.
fn total<R: Relief>(surface: &Surface<R>, degrees: f64, indices: [f64; 2]) -> f64 {
    let [n_i, n_o] = indices;
    let cos_i = degrees.to_radians().cos();
    let passage = if n_i == n_o {
        Passage::Reflection
    } else {
        Passage::TransmissionInto(n_o)
    };
    let diffuse = surface
        .diffuse_albedo(cos_i, green(), n_i, passage, to(QUADRATURE))
        .unwrap();
    let cos_t = (1.0 - (n_i / n_o * degrees.to_radians().sin()).powi(2)).sqrt();
    let k0 = green().wavenumber().radians_per_metre();
    let phi_z = if n_i == n_o {
        2.0 * k0 * n_i * cos_i
    } else {
        k0 * (n_i * cos_i - n_o * cos_t)
    };
    let (r, _) = surface.relief().autocorrelation(phi_z, to(1e-9)).unwrap();
    r.delta_weight() + diffuse
}

fn mirror(sigma: f64, length: f64) -> Surface<PlainHeights> {
    Surface::of_heights(Boundary::Mirror, heights(sigma, length))
}

#[test]
fn rough_mirrors_have_the_energy_of_an_independent_calculation() {
    // e^(−g) + diffuse at 0, 45, 60, 75, 85°, to the digits to which they are known
    let rows = [
        (0.05, 10.0, [1.0000, 1.0000, 1.0000, 0.9995, 1.0025]),
        (0.1, 5.0, [1.0000, 1.0000, 1.0000, 0.9974, 1.0273]),
        (0.1, 2.0, [1.0001, 0.9992, 0.9868, 1.0255, 1.0946]),
        (0.3, 3.0, [1.0002, 0.9953, 0.9749, 1.0250, 1.465]),
        (1.0, 10.0, [1.0000, 0.9985, 0.9844, 0.9639, 1.434]),
        (1.0, 40.0, [1.0000, 1.0000, 1.0000, 0.9995, 0.9828]),
    ];
    let mut wrong = vec![];
    for (sigma, length, row) in rows {
        let slow = mirror(sigma, length);
        let [sigma, length] = [sigma, length].map(|x| x * green().metres());
        let few = GaussianHeights::isotropic(sigma, length).unwrap();
        let fast = Surface::of_heights(Boundary::Mirror, few);
        for (degrees, expected) in [0.0, 45.0, 60.0, 75.0, 85.0].into_iter().zip(row) {
            let printed = if expected > 1.2 { 5e-4 } else { 5e-5 };
            for found in [
                total(&slow, degrees, [1.0, 1.0]),
                total(&fast, degrees, [1.0, 1.0]),
            ] {
                if (found - expected).abs() > printed + 2.0 * QUADRATURE {
                    wrong.push((sigma, length, degrees, found, expected));
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong:?}");
}

#[test]
fn gentle_surfaces_conserve_energy_up_to_30_degrees() {
    // α = 2 σ/l up to 0.1, correlation from 2 wavelengths
    for (sigma, length) in [
        (0.1, 2.0),
        (0.02, 2.0),
        (0.2, 4.0),
        (0.5, 10.0),
        (0.3, 20.0),
        (1.0, 20.0),
    ] {
        for degrees in [0.0, 15.0, 30.0] {
            let found = total(&mirror(sigma, length), degrees, [1.0, 1.0]);
            assert!(
                (found - 1.0).abs() < 3e-4,
                "{sigma} {length} {degrees}: {found}"
            );
        }
    }
}

#[test]
fn rough_windows_conserve_energy() {
    for (sigma, length) in [(0.05, 10.0), (0.1, 5.0), (1.0, 40.0)] {
        let surface = Surface::of_heights(Boundary::Window, heights(sigma, length));
        for degrees in [0.0, 45.0, 70.0] {
            let found = total(&surface, degrees, [1.0, 1.5]);
            assert!(
                (found - 1.0).abs() < 1e-4 + 2.0 * QUADRATURE,
                "{sigma} {length} {degrees}: {found}"
            );
        }
    }
    for (sigma, length) in [(0.3, 3.0), (1.0, 10.0)] {
        let surface = Surface::of_heights(Boundary::Window, heights(sigma, length));
        for degrees in [0.0, 45.0] {
            let found = total(&surface, degrees, [1.0, 1.5]);
            assert!(
                (found - 1.0).abs() < 1e-4 + 2.0 * QUADRATURE,
                "{sigma} {length} {degrees}: {found}"
            );
        }
    }
}

#[test]
fn lossless_phase_screens_lose_what_is_evanescent() {
    let screen = PlainHeights {
        exponent: Some(2.0),
        ..heights(0.1, 12.0)
    };
    let surface = Surface::of_phases(Boundary::Mirror, screen);
    for (degrees, expected) in [(0.0, 1.0), (40.0, 1.0), (70.0, 0.9810), (80.0, 0.7549)] {
        let found = total(&surface, degrees, [1.0, 1.0]);
        assert!(
            (found - expected).abs() < 5e-5 + 2.0 * QUADRATURE,
            "{degrees}: {found} {expected}"
        );
    }
}

/// `∫ f cos_o dω` by the midpoint rule.
fn brute(surface: &Surface<PlainHeights>, degrees: f64, steps: [usize; 2]) -> f64 {
    let i = direction(degrees.to_radians(), 0.0);
    let [polar, azimuth] = steps.map(|n| n as f64);
    let mut sum = 0.0;
    for a in 0..steps[0] {
        let theta = (a as f64 + 0.5) * FRAC_PI_2 / polar;
        for b in 0..steps[1] {
            // half a turn: the plane of incidence is one of symmetry
            let psi = (b as f64 + 0.5) * PI / azimuth;
            let geometry = Geometry::on_plane(i, direction(theta, psi), green()).unwrap();
            let frames = RayFrames::of_surface(&geometry).unwrap();
            let f = surface
                .scattering_function(
                    &geometry,
                    &frames,
                    &IncidentCoherence::plane_wave(),
                    to(1e-5),
                )
                .unwrap();
            sum += f.element(0, 0) * theta.cos() * theta.sin();
        }
    }
    sum * (FRAC_PI_2 / polar) * (PI / azimuth) * 2.0
}

#[test]
fn with_the_cap_no_light_is_made() {
    let free = mirror(0.3, 3.0);
    let capped = free
        .clone()
        .with_cap(green(), 1.0, Passage::Reflection, to(1e-3))
        .unwrap();
    let error = capped.caps()[0].error();
    assert!(error < 2e-3, "{error}");
    for degrees in [20.0, 75.0, 85.0] {
        let coherent = total(&free, degrees, [1.0; 2])
            - free
                .diffuse_albedo(
                    degrees.to_radians().cos(),
                    green(),
                    1.0,
                    Passage::Reflection,
                    to(QUADRATURE),
                )
                .unwrap();
        let [without, with] = [&free, &capped].map(|s| coherent + brute(s, degrees, [90, 90]));
        // the same sum twice as fine differs by less than 1e-3: the lobes are 0.1 rad wide and more
        let expected = total(&free, degrees, [1.0; 2]);
        assert!(
            (without - expected).abs() < 1e-3,
            "{degrees}: {without} {expected}"
        );
        assert!(with <= 1.0 + error + 1e-3, "{degrees}: {with}");
        assert!(with <= without + 1e-12);
    }
    let other = Geometry::on_plane(direction(0.3, 0.0), direction(0.2, 1.0), green())
        .unwrap()
        .between(1.5, 1.5)
        .unwrap();
    let frames = RayFrames::of_surface(&other).unwrap();
    let light = IncidentCoherence::plane_wave();
    let missing = capped.scattering_function(&other, &frames, &light, to(1e-3));
    assert!(matches!(
        missing,
        Err(SurfaceError::NoCap { incident: 1.5, .. })
    ));
}

#[test]
fn the_cap_is_idle_where_a_shadowed_surface_is_a_microfacet_model() {
    let relief = heights(3.0, 60.0);
    let surface = Surface::of_heights(Boundary::Mirror, relief)
        .with_shadowing()
        .unwrap();
    let surface = surface
        .with_cap(green(), 1.0, Passage::Reflection, to(1e-3))
        .unwrap();
    let cap = &surface.caps()[0];
    for degrees in [0.0, 30.0, 60.0, 75.0, 80.0f64] {
        let a = cap.albedo_ratio(degrees.to_radians().cos());
        assert!(a < 1.0 + 1e-3, "{degrees}: {a}");
    }
}

#[test]
fn lobes_that_are_not_round_get_no_cap() {
    #[derive(Clone, Debug)]
    struct Stretched;
    impl Relief for Stretched {
        fn autocorrelation(
            &self,
            _: f64,
            _: Tolerance,
        ) -> Result<
            (mueller16::Autocorrelation, mueller16::Approximation),
            mueller16::AutocorrelationError,
        > {
            let r = mueller16::Autocorrelation::gaussian(&nalgebra::Matrix2::new(
                1e-12, 0.0, 0.0, 4e-12,
            ))?;
            let exact = mueller16::Approximation {
                method: mueller16::Method::Exact,
                terms: 1,
                error: 0.0,
            };
            Ok((r, exact))
        }
        fn slope_covariance(&self) -> Option<nalgebra::Matrix2<f64>> {
            None
        }
    }
    let surface = Surface::of_heights(Boundary::Mirror, Superposed(Stretched, heights(0.0, 3.0)));
    assert!(matches!(
        surface.clone().with_shadowing(),
        Err(SurfaceError::NoSlopes)
    ));
    let refused = surface.with_cap(green(), 1.0, Passage::Reflection, to(1e-3));
    assert!(matches!(refused, Err(SurfaceError::NotRound { .. })));
}
