//! Footprints of sources: what was chosen keeps the tolerance, any partition gives the same light, Gaussians converge as
//! published.

use mueller16::{
    Approximation, Autocorrelation, AutocorrelationError, Channels, Flat, Footprint,
    FootprintError, Geometry, Method, Relief, Representation, Tolerance,
};
use nalgebra::{Matrix2, Vector2, Vector3};
use stokes::{Envelope, GaussianPeak, ModeWidth, Mueller};

use crate::tools::{green, oblique, over_disk, over_rectangle};

const DISTANCE: f64 = 100.0;
const HALF: f64 = 5e-3;

fn tolerance(relative: f64) -> Tolerance {
    Tolerance::relative(relative).unwrap()
}

/// A round lobe whose standard deviation is `sigma` on a source that faces the surface at the distance.
fn lobe(sigma: f64) -> Autocorrelation {
    let k = green().wavenumber().radians_per_metre();
    let correlation = DISTANCE / (k * sigma);
    Autocorrelation::gaussian(&Matrix2::from_diagonal_element(correlation.powi(2))).unwrap()
}

fn straight(at: [f64; 2]) -> Geometry {
    let k = green().wavenumber().radians_per_metre();
    Geometry::on_plane(Vector3::z(), Vector3::z(), green())
        .unwrap()
        .observed_at(&(Vector2::from(at) * (k / DISTANCE)))
        .unwrap()
}

fn facing(envelope: Envelope) -> Footprint {
    Footprint::new(envelope, [Vector3::x(), Vector3::y()], DISTANCE).unwrap()
}

/// The transfer by the integral over source points.
fn direct(r: &Autocorrelation, geometry: &Geometry, disk: bool, half: [f64; 2]) -> f64 {
    let k = green().wavenumber().radians_per_metre();
    let average = |m: &Vector2<f64>| r.spectrum(&(geometry.tangential() + m * (k / DISTANCE)));
    let (sum, area) = if disk {
        (
            over_disk(half[0], average),
            std::f64::consts::PI * half[0] * half[0],
        )
    } else {
        (over_rectangle(half, average), 4.0 * half[0] * half[1])
    };
    sum / area / green().metres().powi(2)
}

#[test]
fn what_is_chosen_keeps_the_tolerance() {
    let mut seen = [false; 2];
    for (disk, half) in [(false, [HALF, 0.6 * HALF]), (true, [HALF, HALF])] {
        let envelope = if disk {
            Envelope::disk(half[0]).unwrap()
        } else {
            Envelope::rectangle(half[0], half[1]).unwrap()
        };
        let source = facing(envelope);
        for sigma in [4.0, 1.2, 0.5, 0.2] {
            let r = lobe(sigma * HALF)
                .scaled(0.7)
                .plus(&lobe(3.0 * sigma * HALF).scaled(0.3));
            let channels = Channels::new(&Mueller::identity(), r.clone());
            for asked in [3e-2, 1e-3, 1e-5] {
                let normal = straight([0.0, 0.0]);
                let (parts, choice) = source
                    .resolved_for(&channels, &normal, tolerance(asked))
                    .unwrap();
                assert!(choice.error <= asked, "{choice:?}");
                assert!(
                    (choice.lobe / (sigma * HALF) - 1.0).abs() < 1e-9,
                    "{choice:?}"
                );
                match choice.representation {
                    Representation::Modes { .. } => seen[0] = true,
                    Representation::Gaussians { count } => {
                        assert_eq!(count, parts.len());
                        seen[1] = true;
                    }
                }
                let peak = direct(&r, &normal, disk, half);
                let mut worst = 0.0;
                for (x, y) in [
                    (0.0, 0.0),
                    (0.5, 0.2),
                    (1.0, 0.0),
                    (1.1, 0.6),
                    (0.0, 1.4),
                    (2.0, -1.0),
                ] {
                    let geometry = straight([x * HALF, y * HALF]);
                    // the same choice for every place of the lobe
                    let parts: Vec<_> = parts
                        .iter()
                        .map(|part| {
                            let mut part = part.clone();
                            let to_source = part.geometry.to_source();
                            part.geometry = geometry.lit_from(to_source).unwrap();
                            part
                        })
                        .collect();
                    let found = channels.transfer_of(&parts).unwrap().total().element(0, 0);
                    worst = f64::max(worst, (found - direct(&r, &geometry, disk, half)).abs());
                }
                println!(
                    "{disk} {sigma} {asked:e} {choice:?} worst {:e}",
                    worst / peak
                );
                // directions are exact in the parts and paraxial here: squares of 5e-5 rad
                assert!(worst / peak < choice.error + 1e-8, "{worst:e} {choice:?}");
            }
        }
    }
    assert!(seen[0] && seen[1], "both ways are tried");
}

#[test]
fn one_gaussian_is_exact_and_several_are_themselves() {
    let spot = |x: f64| GaussianPeak {
        peak: 1.0 + x,
        centre: Vector2::new(x * HALF, 0.3 * x * HALF),
        covariance: Matrix2::new(1.0, 0.2, 0.2, 0.5) * HALF.powi(2),
    };
    let channels = Channels::new(&Mueller::identity(), lobe(0.1 * HALF));
    let normal = straight([0.3 * HALF, 0.0]);
    for (peaks, count) in [(vec![spot(0.0)], 1), (vec![spot(0.0), spot(1.7)], 2)] {
        let source = facing(Envelope::mixture(&peaks).unwrap());
        let (parts, choice) = source
            .resolved_for(&channels, &normal, tolerance(1e-9))
            .unwrap();
        assert_eq!(
            (parts.len(), choice.error < 1e-12),
            (count, true),
            "{choice:?}"
        );
        let shares: f64 = parts.iter().map(|part| part.share).sum();
        assert!((shares - 1.0).abs() < 1e-15);
    }
}

#[test]
fn an_oblique_source_is_the_average_over_its_points() {
    let geometry = oblique([0.0, 0.0])
        .observed_at(&Vector2::new(400.0, -700.0))
        .unwrap();
    let across = Vector3::y().cross(&geometry.to_source()).normalize();
    // a lamp that faces elsewhere
    let tilted = (across * 0.8 + geometry.to_source() * 0.6).normalize();
    let other = geometry.to_source().cross(&across);
    let tangents = [tilted, (other - tilted * other.dot(&tilted)).normalize()];
    let peak = |peak, x: f64, size: f64| GaussianPeak {
        peak,
        centre: Vector2::new(x, -0.5 * x),
        covariance: Matrix2::new(1.0, 0.3, 0.3, 0.7) * size * size,
    };
    let envelope = Envelope::mixture(&[peak(1.0, 6e-3, 5e-3), peak(1.2, -9e-3, 3e-3)]).unwrap();
    let source = Footprint::new(envelope.clone(), tangents, DISTANCE).unwrap();
    let r = Autocorrelation::gaussian(&Matrix2::new(1.2, 0.4, 0.4, 0.9).scale(1e-6)).unwrap();
    let channels = Channels::new(&Mueller::identity(), r.clone());
    let modes = envelope.modes(ModeWidth::VarianceMatched, 40).unwrap();
    let light = source.coherence(&geometry, &modes).unwrap();
    let by_modes = channels
        .transfer(&geometry, &light)
        .unwrap()
        .total()
        .element(0, 0);
    let (parts, _) = source
        .resolved_for(&channels, &geometry, tolerance(1e-6))
        .unwrap();
    let by_parts = channels.transfer_of(&parts).unwrap().total().element(0, 0);
    let centre = envelope.centroid();
    let of_points = |mirrored: f64| {
        crate::tools::over_plane(80, &(Matrix2::identity() * 0.5e-3), |m| {
            let m_c = (m - centre) * mirrored;
            let way = geometry.to_source() * DISTANCE + tangents[0] * m_c.x + tangents[1] * m_c.y;
            let there = geometry.lit_from(way.normalize()).unwrap();
            (envelope.value(m) * r.spectrum(&there.tangential())).into()
        })
        .value
        .re / envelope.area()
            / green().metres().powi(2)
    };
    let expected = of_points(1.0);
    // paraxial beside exact directions: k (1.5e-4)²/2 = 0.1 rad/m beside lobes of 1000 rad/m on their slopes
    assert!(
        (by_modes / expected - 1.0).abs() < 1e-3 + modes.relative_error(),
        "{by_modes} {expected}"
    );
    assert!(
        (by_parts / expected - 1.0).abs() < 1e-3,
        "{by_parts} {expected}"
    );
    assert!((of_points(-1.0) / expected - 1.0).abs() > 1e-2);
}

#[test]
fn any_partition_gives_the_same_light() {
    // six Gaussians as one piece, as two, three and six, each by its modes about its own centroid
    let spots: Vec<_> = (0..6)
        .map(|i| {
            let x = f64::from(i);
            GaussianPeak {
                peak: 1.0 + (1.3 * x).sin().abs(),
                centre: Vector2::new(0.3 * x, (2.1 * x).sin() * 0.4) * HALF,
                covariance: Matrix2::new(0.5, 0.1, 0.1, 0.3) * HALF.powi(2),
            }
        })
        .collect();
    let whole = Envelope::mixture(&spots).unwrap();
    let r = lobe(0.5 * HALF);
    let channels = Channels::new(&Mueller::identity(), r.clone());
    let geometry = straight([0.3 * HALF, -0.2 * HALF]);
    let k = green().wavenumber().radians_per_metre();
    let average = crate::tools::over_plane(120, &(Matrix2::identity() * 0.06 * HALF), |m| {
        let at = geometry.tangential() + (m - whole.centroid()) * (k / DISTANCE);
        (whole.value(m) * r.spectrum(&at)).into()
    });
    let expected = average.value.re / whole.area() / green().metres().powi(2);
    for size in [6, 3, 2, 1] {
        let sum: f64 = spots
            .chunks(size)
            .map(|spots| {
                let piece = Envelope::mixture(spots).unwrap();
                let m = piece.centroid() - whole.centroid();
                let to_source = Vector3::new(m.x, m.y, DISTANCE).normalize();
                let geometry = geometry.lit_from(to_source).unwrap();
                let share = piece.area() / whole.area();
                let modes = piece.modes(ModeWidth::VarianceMatched, 60).unwrap();
                let light = facing(piece).coherence(&geometry, &modes).unwrap();
                let found = channels.transfer(&geometry, &light).unwrap().total();
                share * found.element(0, 0)
            })
            .sum();
        // sines of angles up to 1e-4 rad for the angles themselves: cubes, 1e-12, and squares of it in distances, 1e-8
        let error = (sum / expected - 1.0).abs();
        assert!(error < 2e-8, "{size}: {error:e}");
    }
}

#[test]
fn gaussian_patches_converge_in_fourth_order() {
    // a slit and a lobe of 0.4 half-widths: [erf(a) − erf(b)]/2 beside the sum of Gaussians, largest difference over the
    // peak by another program
    let half = [HALF, 1e-3 * HALF];
    let source = facing(Envelope::rectangle(half[0], half[1]).unwrap());
    let r = lobe(0.4 * HALF);
    let channels = Channels::new(&Mueller::identity(), r.clone());
    let peak = direct(&r, &straight([0.0, 0.0]), false, half);
    for (count, expected) in [
        (1, 0.150_263_3),
        (2, 0.020_126_1),
        (5, 2.083_82e-4),
        (20, 7.592_1e-7),
    ] {
        let patches = source.envelope().patches([count, 1]).unwrap();
        let worst = (0..=80)
            .map(|i| {
                let geometry = straight([f64::from(i) * 0.025 * HALF, 0.0]);
                let parts = source.parts(&geometry, &patches).unwrap();
                let found = channels.transfer_of(&parts).unwrap().total().element(0, 0);
                (found - direct(&r, &geometry, false, half)).abs() / peak
            })
            .fold(0.0, f64::max);
        // found at 81 places, up to 1 % below the top between them; directions of 1e-4 rad are exact in the parts only
        let error = (worst - expected).abs();
        assert!(error < 1e-2 * expected + 1e-8, "{count}: {worst:e}");
    }
}

/// A relief that says what it was asked for.
struct Ground;

impl Relief for Ground {
    fn autocorrelation(
        &self,
        _phi_z: f64,
        tolerance: Tolerance,
    ) -> Result<(Autocorrelation, Approximation), AutocorrelationError> {
        let r = Autocorrelation::constant(0.25).plus(&lobe(0.3 * HALF).scaled(0.75));
        let approximation = Approximation {
            method: Method::PoissonSum,
            terms: 2,
            error: tolerance.get(),
        };
        Ok((r, approximation))
    }

    fn slope_covariance(&self) -> Option<Matrix2<f64>> {
        None
    }
}

#[test]
fn one_call_returns_the_transfer_and_what_was_chosen() {
    let half = [HALF, 0.6 * HALF];
    let source = facing(Envelope::rectangle(half[0], half[1]).unwrap());
    let geometry = straight([0.4 * HALF, 0.0]);
    let report = source
        .transfer(&Ground, &Mueller::identity(), &geometry, tolerance(1e-3))
        .unwrap();
    assert_eq!(report.autocorrelation.error, 5e-4);
    assert!(report.footprint.error <= 5e-4 && report.error() <= 1e-3);
    assert_eq!(report.delta_weight, 0.25);
    let r = lobe(0.3 * HALF).scaled(0.75);
    let expected = direct(&r, &geometry, false, half);
    let found = report.transfer.total().element(0, 0);
    let peak = direct(&r, &straight([0.0, 0.0]), false, half);
    assert!((found - expected).abs() < report.footprint.error * peak + 1e-8 * peak);
    // a mirror has no part that decays
    let mirror = source
        .transfer(&Flat, &Mueller::identity(), &geometry, tolerance(1e-3))
        .unwrap();
    assert_eq!(
        (mirror.delta_weight, mirror.transfer.total().element(0, 0)),
        (1.0, 0.0)
    );
}

#[test]
fn what_cannot_be_had_is_refused() {
    let source = facing(Envelope::disk(HALF).unwrap());
    let geometry = straight([0.0, 0.0]);
    let mirror = Channels::new(&Mueller::identity(), Autocorrelation::constant(0.5));
    let error = source
        .resolved_for(&mirror, &geometry, tolerance(1e-3))
        .unwrap_err();
    assert_eq!(error, FootprintError::Delta { weight: 0.5 });
    assert!(
        error
            .to_string()
            .contains("trace it as a mirror or an order")
    );
    let narrow = Channels::new(&Mueller::identity(), lobe(1e-4 * HALF));
    let error = source
        .resolved_for(&narrow, &geometry, tolerance(1e-6))
        .unwrap_err();
    assert!(
        error.to_string().contains("sample its points instead"),
        "{error}"
    );
    for distance in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let disk = Envelope::disk(1.0).unwrap();
        let wrong = Footprint::new(disk, [Vector3::x(), Vector3::y()], distance);
        assert!(matches!(wrong, Err(FootprintError::Distance(_))));
    }
    let disk = Envelope::disk(1.0).unwrap();
    assert!(Footprint::new(disk, [Vector3::x(), Vector3::x()], 1.0).is_err());
}
