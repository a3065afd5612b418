//! What is printed in sections S2 and S4.2 of the supplemental and does not hold of matter, next to what does. The shape
//! matrix by itself (S2.12, S2.13, S2.17) and odd orders in free space have theirs in `stokes`, Σ as a square in `csdm`.

use mueller16::{
    Autocorrelation, Channels, Energy, Geometry, IncidentCoherence, Matter, Population,
};
use nalgebra::{Matrix2, Matrix2x3, Matrix3, Vector2, Vector3};
use num_complex::Complex64;
use std::f64::consts::{PI, TAU};
use stokes::{
    Components, Envelope, Family, GeneralizedStokes, HermiteSeries, ModeWidth, Mueller,
    ShapeMatrix, StokesVector, covariant_mode, covariant_mode_fourier, plane,
};

use crate::tools::{
    MICRON, blazed, dense, direction, green, incident_frame, oblique, outgoing_frame, over_plane,
    root_of_size, skew_root,
};

fn far_apart(right: f64, printed: f64) -> bool {
    (right - printed).abs() > 0.01 * right.abs()
}

#[test]
fn s2_1_and_s2_2_differ_by_the_cosine_that_energy_needs() {
    // a mirror of albedo 1 over a wide lobe-free patch: ∫ f cos_o dω of its image
    for degrees in [0.0, 40.0, 70.0] {
        let to_source = direction(degrees, 0.0);
        let mirror = Geometry::on_plane(to_source, direction(degrees, 180.0), green()).unwrap();
        let r = Autocorrelation::gaussian(&Matrix2::from_diagonal_element(2.5e-9)).unwrap();
        let channels = Channels::new(&Mueller::identity(), r);
        // lobes of 2e4 rad/m, 1.8e-3 of k: nothing reaches the horizon and cosines change by as much
        let k = green().wavenumber().radians_per_metre();
        let albedo = |energy: Energy| {
            let step = Matrix2::identity() * 5e3;
            over_plane(34, &step, |phi| {
                let there = mirror.observed_at(phi).unwrap();
                let f = channels
                    .transfer(&there, &IncidentCoherence::plane_wave())
                    .unwrap();
                // d²φ = k² cos_o dω; scattered power over that of the surface's irradiance, E cos_i
                let factor = energy.factor(&there).unwrap() / there.cos_outgoing();
                let power = f.total().element(0, 0) * factor / (k * k * to_source.z);
                power.into()
            })
            .value
            .re
        };
        let (printed, corrected) = (albedo(Energy::Printed), albedo(Energy::Conserving));
        assert!((corrected - 1.0).abs() < 1e-12, "{degrees}: {corrected}");
        // 1/cos²: 8.55 times at 70°, up to the width of the lobe
        let excess = to_source.z.powi(-2);
        let tan = degrees.to_radians().tan();
        assert!(
            (printed / excess - 1.0).abs() < 1e-5 * (1.0 + tan * tan) * 4.0,
            "{degrees}: {printed}"
        );
        assert!(degrees == 0.0 || far_apart(corrected, printed));
    }
}

#[test]
fn s2_3_and_s2_5_hold_for_transverse_separations_only() {
    // a spherical wave from the source point m, exactly: phase k|r r̂ + ξ − m|, beside the first order k r̂·ξ − (k/r) ξ·m
    let k = 1e7;
    let (r, axis) = (1.0, Vector3::z());
    let m = Vector3::new(1e-3, 0.0, 0.0);
    let distance = |xi: Vector3<f64>| {
        let d = xi - m;
        // |r ẑ + d| − r without cancellation
        let extra = 2.0 * r * d.z + d.norm_squared();
        extra / ((r * r + extra).sqrt() + r)
    };
    let phase = |xi: Vector3<f64>| k * (distance(xi * 0.5) - distance(-xi * 0.5));
    let printed = |xi: Vector3<f64>| k * axis.dot(&xi) - k / r * xi.dot(&m);
    let across = Vector3::new(1e-4, 2e-4, 0.0);
    // half the square of m/r
    assert!((phase(across) / printed(across) - 1.0).abs() < 1e-6);
    // along the ray the source point m turns the phase by k ξ_z (m/r)²/2, of which the expansion in ξ·m knows nothing
    let along = Vector3::new(0.0, 0.0, 0.3);
    let missed = phase(along) - printed(along);
    assert!(
        (missed + k * 0.3 * 0.5e-6).abs() < 0.03 * missed.abs(),
        "{missed}"
    );
    assert!(missed.abs() > 1.0);
    // what is implemented is written for separations across the ray: a frame's two coordinates
    let geometry = oblique([0.0, 0.0]);
    assert!(
        outgoing_frame(&geometry)
            .x()
            .dot(&geometry.to_observer())
            .abs()
            < 1e-15
    );
}

#[test]
fn s2_6_s2_8_and_s2_9_have_the_factors_of_the_plane() {
    let theta = Matrix2::new(0.9, 0.3, 0.3, 0.6);
    // (S2.6): ⟨Ψ((k/r) ξ)|Ψ̃((k/r) ξ)⟩ = (r/k)², not (r/k)³
    let (k, r) = (2.3, 3.7);
    let step = Matrix2::identity() * 0.25 * r / k;
    let product = over_plane(60, &step, |xi| {
        let w = xi * (k / r);
        let (n, m) = (2, 1);
        (covariant_mode(Family::Covariant, n, m, &theta, &w).unwrap()
            * covariant_mode(Family::Dual, n, m, &theta, &w).unwrap())
        .into()
    });
    assert!((product.value.re / (r / k).powi(2) - 1.0).abs() < 1e-12);
    assert!(far_apart(product.value.re, (r / k).powi(3)));
    // (S2.8): ⟨e^(−iw·x)|Ψ̃^Θ_nm(w)⟩ = 2π (−i)^(n+m) Ψ^(Θ⁻¹)_nm(x), not (2π)^(3/2)
    let x = Vector2::new(0.7, -0.4);
    for (n, m) in [(0, 0), (1, 0), (2, 1)] {
        let found = over_plane(60, &(Matrix2::identity() * 0.25), |w| {
            Complex64::cis(-w.dot(&x)) * covariant_mode(Family::Dual, n, m, &theta, w).unwrap()
        })
        .value;
        let turned = found * Complex64::new(0.0, 1.0).powu((n + m) as u32);
        let dual = covariant_mode(Family::Covariant, n, m, &plane::inverse(&theta), &x).unwrap();
        assert!((turned - TAU * dual).norm() < 1e-12, "{n} {m}");
        assert!(far_apart(turned.re, TAU.powf(1.5) * dual));
        let whole = covariant_mode_fourier(Family::Dual, n, m, &theta, &x).unwrap();
        assert!((whole - found).norm() < 1e-12);
    }
}

/// One Gaussian envelope whose axes are nobody's.
fn envelope() -> Envelope {
    let root = root_of_size(120.0);
    Envelope::gaussian(&(root.transpose() * root)).unwrap()
}

fn unpolarized(modes: HermiteSeries, geometry: &Geometry) -> GeneralizedStokes {
    GeneralizedStokes::new(
        Components::Shared {
            modes,
            stokes: StokesVector::UNPOLARIZED,
        },
        ShapeMatrix::from_root(&skew_root()).unwrap(),
        incident_frame(geometry),
        geometry.wavelength(),
        1.0,
    )
    .unwrap()
}

#[test]
fn s4_1_projects_on_the_outgoing_shape() {
    // as printed, on Ψ̃^Θ' of the incident light: with one mode the scattered light would keep the incident shape
    let geometry = oblique([3e4, -2e4]);
    let frame = outgoing_frame(&geometry);
    let matter = Matter::new(vec![Population::of_sixteen(&dense(), blazed(), envelope())]).unwrap();
    let incident = unpolarized(HermiteSeries::fundamental(1.0), &geometry);
    let (found, loss) = matter
        .scatter_in_one_shape(&geometry, &incident, Energy::Printed, frame, 0.5, 0)
        .unwrap();
    assert!(
        loss.norm < 1e-12,
        "one mode of the outgoing shape is all: {loss:?}"
    );
    // C_0(ξ)/C_0(0) = F{I}((k/r) P ξ)/F{I}(0), the law of Van Cittert and Zernike for the footprint
    let p = geometry.outgoing_projection(&frame);
    let k = green().wavenumber().radians_per_metre();
    let xi = Vector2::new(1e-4, 3e-4);
    let law = envelope().fourier(&(p * xi * (k / 0.5))) / envelope().area();
    assert!((found.degree_of_coherence(&xi) - law).norm() < 1e-13);
    let (printed, lost) = found.in_shape(*incident.shape(), 0);
    assert!(lost.norm > 0.1);
    assert!(far_apart(law.re, printed.degree_of_coherence(&xi).re));
}

#[test]
fn s4_1_transforms_over_the_incident_frame() {
    // the argument (k/s) Q' r' of the Fourier transform is that of the incident frame; with the outgoing Q the footprint of
    // the light would turn with the observer
    let geometry = oblique([1.2e5, -0.9e5]);
    let incident = unpolarized(HermiteSeries::fundamental(1.0), &geometry);
    let r = Autocorrelation::gaussian(&Matrix2::from_diagonal_element(1e-10)).unwrap();
    let channels = Channels::new(&Mueller::identity(), r.clone());
    let found = channels
        .amplitudes(&geometry, &incident)
        .unwrap()
        .stokes(0)
        .s0();
    let k = green().wavenumber().radians_per_metre();
    let with = |axes: [Vector3<f64>; 2]| {
        over_plane(200, &(Matrix2::identity() * 0.6 * MICRON), |x| {
            let there = Vector3::new(x.x, x.y, 0.0);
            let w = Vector2::new(axes[0].dot(&there), axes[1].dot(&there)) * k;
            let y = skew_root() * w;
            let light = (-0.5 * y.norm_squared()).exp() * (skew_root().determinant() / PI).sqrt();
            r.value(x) * light * Complex64::cis(-geometry.tangential().dot(x))
        })
        .value
        .re / green().metres().powi(2)
    };
    let frame = incident_frame(&geometry);
    let corrected = with([frame.x(), frame.y()]);
    // 802 additions of a row and of rows, and exponents of up to 4
    assert!(
        (found / corrected - 1.0).abs() < 1000.0 * f64::EPSILON,
        "{found} {corrected}"
    );
    let frame = outgoing_frame(&geometry);
    assert!(far_apart(found, with([frame.x(), frame.y()])));
}

#[test]
fn s4_1_ii_restricts_to_the_transverse_plane_before_it_inverts_and_has_a_minus_sign() {
    // the flat footprint has no extent along its normal: its 3D Hessian cannot be inverted first at all
    let geometry = oblique([3e4, -2e4]);
    let frame = outgoing_frame(&geometry);
    let matter = Matter::new(vec![Population::of_sixteen(&dense(), blazed(), envelope())]).unwrap();
    let p = geometry.outgoing_projection(&frame);
    let theta = matter.shape(&p).unwrap().theta();
    let [t1, t2] = geometry.tangents();
    let tangents = nalgebra::Matrix3x2::from_columns(&[t1, t2]);
    let hessian = -(tangents * envelope().covariance() * tangents.transpose());
    assert!(hessian.determinant().abs() < 1e-10 * hessian.norm().powi(3));
    let q = Matrix2x3::from_rows(&[frame.x().transpose(), frame.y().transpose()]);
    let corrected = -(q * hessian * q.transpose()).try_inverse().unwrap();
    assert!((theta - corrected).amax() < 1e-13 * theta.amax());
    // as printed, without the minus: no shape
    assert!(ShapeMatrix::from_theta(&-corrected).is_err());
    // with a thickness that makes the inverse exist: another matrix
    let thick = hessian - Matrix3::identity() * 1e-3 * hessian.norm();
    let inverted_first = -(q * thick.try_inverse().unwrap() * q.transpose());
    assert!((theta - inverted_first).amax() > 0.1 * theta.amax());
    // Q'[..]⁻¹Q with Q the turn within the transverse plane, as printed in (S2.13): the frame turned the wrong way
    let turn = Matrix2::new(0.8, -0.6, 0.6, 0.8);
    let turned = frame.turned(f64::atan2(0.6, 0.8));
    let found = matter
        .shape(&geometry.outgoing_projection(&turned))
        .unwrap()
        .theta();
    let right = turn.transpose() * theta * turn;
    let wrong = turn * theta * turn.transpose();
    assert!((found - right).amax() < 1e-13 * theta.amax());
    assert!((found - wrong).amax() > 0.1 * theta.amax());
}

#[test]
fn s4_1_needs_signed_channels() {
    // σ σ* ≥ 0 of sixteen amplitudes: a mirror at normal incidence turns S2 and S3 over, r_p = −r_s
    let mirror = Mueller::from_rows([
        [1.0, 0.0, 0.0, 0.0],
        [0.0, 1.0, 0.0, 0.0],
        [0.0, 0.0, -1.0, 0.0],
        [0.0, 0.0, 0.0, -1.0],
    ]);
    let squares = Mueller::from(mirror.to_matrix().abs());
    let geometry = oblique([2e4, 0.0]);
    let scattered = |m: &Mueller| {
        let population = Population::of_mueller(m, blazed(), envelope());
        let matter = Matter::new(vec![population.unwrap()]).unwrap();
        let modes = matter.modes(ModeWidth::VarianceMatched, 0).unwrap();
        let light = unpolarized(HermiteSeries::fundamental(1.0), &geometry);
        let circular = light
            .through(
                &(nalgebra::Matrix4::from_fn(|i, j| {
                    f64::from(u8::from((i == 3 || i == 0) && j == 0))
                }))
                .into(),
                *light.frame(),
            )
            .unwrap();
        let out = matter
            .scatter(
                &modes,
                &geometry,
                &circular,
                Energy::Printed,
                outgoing_frame(&geometry),
                1.0,
            )
            .unwrap();
        out[0].stokes().stokes
    };
    let (right, printed) = (scattered(&mirror), scattered(&squares));
    assert!(
        (right.s3() / right.s0() + 1.0).abs() < 1e-14,
        "the hand is swapped"
    );
    assert!(
        (printed.s3() / printed.s0() - 1.0).abs() < 1e-14,
        "and kept by squares"
    );
}

#[test]
fn odd_orders_of_light_reach_the_scattered_power() {
    // said to be evanescent: without them a lopsided source lights one side of the lobe as the other
    let geometry = oblique([1e5, 0.0]);
    let opposite = oblique([-1e5, 0.0]);
    let r = Autocorrelation::gaussian(&Matrix2::from_diagonal_element(1e-10)).unwrap();
    let channels = Channels::new(&Mueller::identity(), r);
    let power = |real: &[f64], geometry: &Geometry| {
        let modes = HermiteSeries::from_real_coefficients(real).unwrap();
        let amplitudes = channels.amplitudes(geometry, &unpolarized(modes, geometry));
        amplitudes.unwrap().stokes(0).s0()
    };
    let skewness = |real: &[f64]| {
        let (a, b) = (power(real, &geometry), power(real, &opposite));
        (a - b) / (a + b)
    };
    let odd = [1.0, 0.0, 0.0, 0.1, 0.0, 0.1, 0.3, 0.0, 0.2, 0.0];
    let even = [1.0, 0.0, 0.0, 0.1, 0.0, 0.1];
    assert!(skewness(&even).abs() < 1e-13, "{}", skewness(&even));
    assert!(skewness(&odd).abs() > 0.01, "{}", skewness(&odd));
}
