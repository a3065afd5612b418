//! One encounter after another: the state of light is four numbers for each envelope, and nothing before the last
//! matter is remembered.

use mueller16::{
    Autocorrelation, Channels, Energy, Geometry, IncidentCoherence, Matter, Population,
};
use nalgebra::{Matrix2, Vector2};
use num_complex::Complex64;
use stokes::{Envelope, Frame, GeneralizedStokes, ModeWidth, Mueller, StokesVector, plane};

use crate::tools::{
    MICRON, blazed, dense, green, light, lopsided, oblique, over_plane, root_of_size,
};

const APART: f64 = 0.2;

fn rough(microns: f64) -> Autocorrelation {
    let root = root_of_size(microns);
    Autocorrelation::gaussian(&(root.transpose() * root)).unwrap()
}

fn gaussian(microns: f64) -> Envelope {
    let root = root_of_size(microns);
    Envelope::gaussian(&(root.transpose() * root)).unwrap()
}

/// The second encounter: light that left the first toward its observer comes from there.
fn second(first: &Geometry, frame: &Frame) -> Geometry {
    let source = -first.to_observer();
    // a surface that faces the light obliquely
    let t1 = (frame.x() * 0.8 + source * 0.6).normalize();
    let t2 = frame.y() - t1 * t1.dot(&frame.y());
    let tangents = [t1, t2.normalize()];
    let mirrored = {
        let n = tangents[0].cross(&tangents[1]);
        n * (2.0 * n.dot(&source)) - source
    };
    Geometry::new(source, mirrored, tangents, green())
        .unwrap()
        .observed_at(&Vector2::new(2e4, -3e4))
        .unwrap()
}

#[test]
fn two_encounters_are_the_product_of_their_matrices() {
    let first = oblique([4e4, -2e4]);
    let frame = crate::tools::outgoing_frame(&first);
    let matter = Matter::new(vec![Population::of_sixteen(
        &dense(),
        blazed(),
        gaussian(300.0),
    )])
    .unwrap();
    let modes = matter.modes(ModeWidth::VarianceMatched, 0).unwrap();
    let incident = light(&first, lopsided());
    let between = matter
        .scatter(&modes, &first, &incident, Energy::Printed, frame, APART)
        .unwrap();
    let geometry = second(&first, &frame);
    let channels = Channels::new(&dense().reversed(), rough(7.0));
    let found = channels
        .amplitudes(&geometry, &between[0])
        .unwrap()
        .stokes(0);

    // (5.1): T = (1/(sλ)²) Σ ∫ I(m) F{R}(φ + Cᵀm) d²m, on the Stokes amplitudes of the first
    let s1 = matter
        .channels()
        .amplitudes(&first, &incident)
        .unwrap()
        .stokes(0);
    let k = green().wavenumber().radians_per_metre();
    let across = first
        .tangents()
        .map(|t| t - first.to_observer() * first.to_observer().dot(&t));
    let c = Matrix2::from_fn(|i, j| across[i].dot(&geometry.tangents()[j])) * (k / APART);
    let profile = &matter.envelopes()[0];
    // nine standard deviations of 410 µm, 17 points in the least
    let average = over_plane(250, &(Matrix2::identity() * 15.0 * MICRON), |m| {
        let at = geometry.tangential() + c.transpose() * m;
        Complex64::from(profile.value(m) * rough(7.0).spectrum(&at))
    });
    let t = dense().reversed().to_matrix() * average.value.re / (APART * green().metres()).powi(2);
    let expected = t * s1.to_vector();
    // 1000 additions of positive numbers, and the rounding of exponents of up to 40
    let error = (found.to_vector() - expected).amax() / expected.amax();
    assert!(error < 1000.0 * f64::EPSILON, "{error:e}");

    // the same as matrices: transfer times irradiance
    let root = modes[0].root() * c;
    let coherence = IncidentCoherence::new(root, modes[0].series()).unwrap();
    let transfer = channels.transfer(&geometry, &coherence).unwrap().total();
    let irradiance = between[0].stokes().stokes;
    let by_matrix = (transfer * irradiance).to_vector();
    assert!((by_matrix - found.to_vector()).amax() < 64.0 * f64::EPSILON * expected.amax());
}

/// Matter of three envelopes of unlike size, with different responses.
fn three() -> Matter {
    let half = Mueller::from_rows([
        [0.6, 0.0, 0.1, 0.0],
        [0.0, -0.4, 0.0, 0.2],
        [0.1, 0.0, 0.3, 0.0],
        [0.0, -0.2, 0.0, 0.5],
    ]);
    let wide = Envelope::mixture(&[stokes::GaussianPeak {
        peak: 0.7,
        centre: Vector2::new(310.0, -210.0) * MICRON,
        covariance: root_of_size(210.0).transpose() * root_of_size(210.0),
    }])
    .unwrap();
    Matter::new(vec![
        Population::of_sixteen(&dense(), blazed(), gaussian(230.0)),
        Population::of_sixteen(&half, rough(5.0), gaussian(190.0)),
        Population::of_sixteen(&half.reversed(), rough(11.0), wide),
    ])
    .unwrap()
}

#[test]
fn several_envelopes_in_one_shape_lose_what_is_reported() {
    let geometry = oblique([2e4, 1e4]);
    let frame = crate::tools::outgoing_frame(&geometry);
    let incident = light(&geometry, lopsided());
    let matter = three();
    let modes = matter.modes(ModeWidth::VarianceMatched, 0).unwrap();
    let parts = matter
        .scatter(&modes, &geometry, &incident, Energy::Printed, frame, APART)
        .unwrap();
    let centre = matter.centroid().unwrap();
    let p = geometry.outgoing_projection(&frame);
    let k = green().wavenumber().radians_per_metre();
    // the sum of the parts, each with the phase of its centroid
    let exact = |xi: &Vector2<f64>| {
        let u = p * xi * (k / APART);
        let mut sum = [Complex64::ZERO; 4];
        for (part, envelope) in parts.iter().zip(matter.envelopes()) {
            let phase = Complex64::cis(-u.dot(&(envelope.centroid() - centre)));
            for (sum, c) in sum.iter_mut().zip(part.at_separation(xi)) {
                *sum += c * phase;
            }
        }
        sum
    };
    let mut last = f64::INFINITY;
    for order in [0, 2, 5, 12, 30] {
        let (one, loss) = matter
            .scatter_in_one_shape(&geometry, &incident, Energy::Printed, frame, APART, order)
            .unwrap();
        // L² norms by the trapezoidal rule, in whitened coordinates: ± 12, step 0.3
        let step = plane::inverse(one.shape().root()) * (0.3 * APART / k);
        let square = |f: &dyn Fn(&Vector2<f64>) -> [Complex64; 4]| {
            over_plane(40, &step, |xi| {
                f(xi).iter().map(Complex64::norm_sqr).sum::<f64>().into()
            })
            .value
            .re
        };
        let whole = square(&exact);
        let lost = square(&|xi: &Vector2<f64>| {
            let (a, b) = (exact(xi), one.at_separation(xi));
            std::array::from_fn(|j| a[j] - b[j])
        });
        let error = (lost / whole).sqrt();
        // a sum of Gaussians: the next 32 orders hold the rest, and rounding is what is left at the end
        assert!(
            (error - loss.norm).abs() < 1e-3 * error + 1e-13,
            "{order}: {error:e} {loss:?}"
        );
        assert!(error < last, "{order}: {error:e}");
        last = error;
        let zero = Vector2::zeros();
        for (j, (a, b)) in exact(&zero)
            .iter()
            .zip(one.at_separation(&zero))
            .enumerate()
        {
            let found = loss.stokes.to_array()[j];
            assert!((a.re - b.re - found).abs() < 1e-13 * exact(&zero)[0].norm());
        }
    }
    assert!(last < 1e-6);
}

#[test]
fn summed_parts_meet_the_next_matter_as_the_one_shape_does() {
    let first = oblique([2e4, 1e4]);
    let frame = crate::tools::outgoing_frame(&first);
    let incident = light(&first, lopsided());
    let matter = three();
    let modes = matter.modes(ModeWidth::VarianceMatched, 0).unwrap();
    let parts = matter
        .scatter(&modes, &first, &incident, Energy::Printed, frame, APART)
        .unwrap();
    let straight = second(&first, &frame);
    let channels = dense_over_two_envelopes();

    // the state of three Stokes vectors, each part from its own centroid
    let origin = matter.centroid().unwrap();
    let [t1, t2] = first.tangents();
    let (mut state, mut encounters) = (vec![], vec![]);
    for ((part, envelope), modes) in parts.iter().zip(matter.envelopes()).zip(&modes) {
        let m = envelope.centroid() - origin;
        let way = straight.to_source() * APART + t1 * m.x + t2 * m.y;
        let geometry = straight.lit_from(way.normalize()).unwrap();
        let across = first
            .tangents()
            .map(|t| t - geometry.to_source() * geometry.to_source().dot(&t));
        let k = green().wavenumber().radians_per_metre();
        let c = Matrix2::from_fn(|i, j| across[i].dot(&geometry.tangents()[j])) * (k / way.norm());
        let coherence = IncidentCoherence::new(modes.root() * c, modes.series()).unwrap();
        encounters.push((geometry, coherence));
        state.push(part.stokes().stokes);
    }
    let transfer = channels.transfer_of_state(&encounters).unwrap();
    let after = transfer.apply(&state);
    assert_eq!(after.len(), 2);
    // 4 × 4K: block by block
    for (q, found) in after.iter().enumerate() {
        let sum = (0..3).fold(StokesVector::DARK, |sum, p| {
            sum + transfer.block(p, q) * state[p]
        });
        assert_eq!(sum, *found);
    }
    let (one, loss) = matter
        .scatter_in_one_shape(&first, &incident, Energy::Printed, frame, APART, 30)
        .unwrap();
    let expected = channels.amplitudes(&straight, &one).unwrap();
    for (q, found) in after.iter().enumerate() {
        let expected = expected.stokes(q).to_vector();
        let error = (found.to_vector() - expected).amax() / expected.amax();
        // centroids 0.3 mm apart at 0.2 m: directions of 1.5e-3 rad, exact on one side and paraxial on the other, which is off
        // by half their square times k, 13 rad/m; beside lobes of 1e5 rad/m on their slope 1e-4, and each square 2e-6
        assert!(error < 1e-3 + 10.0 * loss.norm, "{q}: {error:e}");
    }
    // without the parts' own directions the two would not agree
    let blind: Vec<_> = encounters
        .iter()
        .map(|(_, c)| (straight, c.clone()))
        .collect();
    let blind = channels.transfer_of_state(&blind).unwrap().apply(&state);
    let expected = expected.stokes(0).to_vector();
    assert!((blind[0].to_vector() - expected).amax() > 5e-3 * expected.amax());
}

fn dense_over_two_envelopes() -> Channels {
    Channels::new(&dense(), rough(13.0)).with(&dense().reversed(), blazed(), 1)
}

#[test]
fn nothing_before_the_last_matter_is_remembered() {
    // two incident lights of one Stokes amplitude after the first matter are one light after it
    let first = oblique([4e4, -2e4]);
    let frame = crate::tools::outgoing_frame(&first);
    let polarizer = Mueller::from_rows([
        [0.5, 0.5, 0.0, 0.0],
        [0.5, 0.5, 0.0, 0.0],
        [0.0; 4],
        [0.0; 4],
    ]);
    let matter = Matter::new(vec![Population::of_sixteen(
        &polarizer,
        rough(6.0),
        gaussian(300.0),
    )])
    .unwrap();
    let modes = matter.modes(ModeWidth::VarianceMatched, 0).unwrap();
    let after = |incident: &GeneralizedStokes| {
        let out = matter
            .scatter(&modes, &first, incident, Energy::Printed, frame, APART)
            .unwrap();
        let s0 = out[0].stokes().stokes.s0();
        out[0].scaled(1.0 / s0).unwrap()
    };
    let a = after(&light(&first, lopsided()));
    let b = after(&light(
        &first,
        stokes::Components::Shared {
            modes: crate::tools::series(4, 0.7),
            stokes: StokesVector::new(1.0, 0.3, -0.2, 0.5),
        },
    ));
    let xi = Vector2::new(1e-4, 2e-4);
    for (a, b) in a.at_separation(&xi).iter().zip(b.at_separation(&xi)) {
        assert!((a - b).norm() < 8.0 * f64::EPSILON);
    }
}
