//! Laws of general matter, and what is no matter.

use std::f64::consts::TAU;

use glam::Vec3A;
use serde_json::{Value, json};

use super::*;
use crate::light::{MuellerResponse, Polarized};
use crate::material::testing::{
    assert_drawn_as_dense, difference, respond, reversed, toward, vertex,
};

fn matter(file: Value) -> Result<Scatterer16, String> {
    let parts = populations(&file).map_err(|e| e.to_string())?;
    Scatterer16::new(&parts, Vec3A::ZERO, Spectrum::constant(1.0))
}

/// A mirror part, a lobe of silk and a thin film that passes one polarization.
fn silk() -> Scatterer16 {
    let mirror = json!([
        [0.2, 0, 0, 0],
        [0, 0.2, 0, 0],
        [0, 0, -0.2, 0],
        [0, 0, 0, -0.2]
    ]);
    let film = json!([[0.6, 0.1], [0.1, {"re": 0.2, "im": 0.3}]]);
    matter(json!({"populations": [
        {"M": mirror, "R": {"kind": "constant"}},
        {"M": mirror, "R": {"kind": "gaussian", "S": [[4e-12, 0], [0, 1e-12]]}},
        {"T": film, "R": {"kind": "gaussian_sum", "weights": [0.5, 0.3], "S_list": [[[1e-12, 0], [0, 1e-12]], [[1e-14, 0], [0, 1e-14]]]},
         "side": "transmission"},
    ]}))
    .unwrap()
}

#[test]
fn drawn_directions_follow_their_density() {
    for o in [toward(20.0, 40.0), -toward(50.0, 10.0)] {
        assert_drawn_as_dense("silk", &silk(), o, 16);
    }
}

#[test]
fn light_retraces_its_path() {
    let silk = silk();
    let f = |o: Vec3A, i: Vec3A| respond(&silk, o, i, Part::Continuous).0 * i.z.abs().recip();
    let front = toward(20.0, 40.0);
    for other in [toward(25.0, 215.0), -toward(25.0, 215.0)] {
        let (there, back) = (f(front, other), f(other, front));
        assert!(there.x_axis.x > 1e-3);
        assert!(
            difference(&there, &reversed(&back)) < 1e-5 * there.x_axis.x,
            "{there} {back}"
        );
    }
}

/// Uniform light from everywhere, seen at `o`: quadrature over both hemispheres, and the mirror.
#[test]
fn what_is_scattered_is_the_area_under_the_autocorrelation() {
    let silk = silk();
    let o = toward(10.0, 0.0);
    let n = 800;
    let mut sums = [0.0; 2];
    for place in 0..n * n {
        let z = 2.0 * ((place / n) as f32 + 0.5) / n as f32 - 1.0;
        let turn = ((place % n) as f32 + 0.5) / n as f32 * std::f32::consts::TAU;
        let r = (1.0 - z * z).sqrt();
        let i = Vec3A::new(r * turn.cos(), r * turn.sin(), z);
        let m00 = respond(&silk, o, i, Part::Continuous).0.x_axis.x;
        sums[usize::from(z < 0.0)] += f64::from(m00) * 2.0 * TAU / (n * n) as f64;
    }
    // all of the narrow lobes propagates; of the wide one, of standard deviation 0.875, a part
    assert!((sums[0] - 0.2).abs() < 1e-4, "{sums:?}");
    let m00 = 0.5 * (0.36 + 0.01 + 0.01 + 0.13);
    assert!(sums[1] > 0.5 * m00 && sums[1] < 0.8 * m00, "{sums:?}");
    let (mirror, _) = respond(
        &silk,
        o,
        super::super::mirror(o, Vec3A::Z),
        Part::Discrete(0),
    );
    assert!((mirror.x_axis.x - 0.2).abs() < 1e-7);
}

#[test]
fn one_gaussian_is_its_transform() {
    let m = json!([[0.8, 0, 0, 0], [0, 0, 0, 0], [0, 0, 0, 0], [0, 0, 0, 0]]);
    let matter = matter(
        json!({"populations": [{"M": m, "R": {"kind": "gaussian", "S": [[4e-12, 1e-12], [1e-12, 2e-12]]}}]}),
    );
    let (o, i) = (toward(30.0, 20.0), toward(24.0, 190.0));
    let found = f64::from(respond(&matter.unwrap(), o, i, Part::Continuous).0.x_axis.x);
    let k = TAU / 550e-9;
    let (x, y) = (k * f64::from(o.x + i.x), k * f64::from(o.y + i.y));
    let exponent = 0.5 * (4e-12 * x * x + 2e-12 * x * y + 2e-12 * y * y);
    let lobe = TAU * f64::sqrt(7e-24) * (-exponent).exp();
    let expected = 0.8 * lobe / (550e-9 * 550e-9) * f64::from(i.z);
    // the exponent takes up what single precision does to k (o + i)
    assert!(
        expected > 0.1 && (found / expected - 1.0).abs() < 1e-4,
        "{found} {expected}"
    );
}

#[test]
fn coherent_light_is_light_from_several_directions() {
    let silk = silk();
    let (o, i) = (toward(20.0, 40.0), toward(22.0, 215.0));
    let root = [Vec3A::new(0.02, 0.004, 0.0), Vec3A::new(0.0, 0.03, 0.0)];
    let coherence = Coherence {
        angular_root: root,
        distance: 1.0,
    };
    let at = vertex(o);
    let (response, _) =
        silk.respond::<Polarized<1>>(&at, i, Part::Continuous, &[550.0], &coherence);
    let MuellerResponse::General {
        matrices: [found], ..
    } = response
    else {
        panic!()
    };
    // the mean of F{R} over the wave vectors of the light
    let k = TAU / 550e-9;
    let n = 200;
    let (mut sum, mut weights) = (0.0, 0.0);
    for place in 0..n * n {
        let at = |c: usize| ((c as f64 + 0.5) / n as f64 * 2.0 - 1.0) * 6.0;
        let (a, b) = (at(place / n), at(place % n));
        let weight = (-0.5 * (a * a + b * b)).exp();
        let x = k * (f64::from(o.x + i.x) + 0.02 * a);
        let y = k * (f64::from(o.y + i.y) + 0.004 * a + 0.03 * b);
        sum += weight * TAU * 2e-12 * (-0.5 * (4e-12 * x * x + 1e-12 * y * y)).exp();
        weights += weight;
    }
    let expected = 0.2 * sum / weights / (550e-9 * 550e-9) * f64::from(i.z);
    assert!(
        (f64::from(found.x_axis.x) / expected - 1.0).abs() < 1e-4,
        "{found} {expected}"
    );
}

#[test]
fn orders_go_where_the_grating_equation_says() {
    // sharp orders of a grating of 2 µm
    let order = |q: f64| population::Part {
        transmits: false,
        mueller: Mueller::from_rows([
            [0.3, 0., 0., 0.],
            [0., 0.3, 0., 0.],
            [0., 0., -0.3, 0.],
            [0., 0., 0., -0.3],
        ]),
        autocorrelation: mueller16::Autocorrelation::constant(1.0)
            .shifted(&Vector2::new(q * TAU / 2e-6, 0.0)),
        envelope: Envelope::disk(1.0).unwrap(),
    };
    let parts = [-2.0, 0.0, 1.0].map(order);
    let grating = Scatterer16::new(&parts, Vec3A::ZERO, Spectrum::constant(1.0)).unwrap();
    let traits = grating.traits();
    assert!(traits.discrete && traits.disperses);
    let o = toward(15.0, 0.0);
    for (place, order) in grating.orders.iter().enumerate() {
        let Some(i) = grating.bend(&vertex(o), Part::Discrete(place as u32), &[550.0]) else {
            continue;
        };
        let q = f64::from(o.x + i.x) * 2e-6 / 550e-9;
        assert!(
            (q - [-2.0, 0.0, 1.0][place]).abs() < 1e-5 && i.y.abs() < 1e-6,
            "{q}"
        );
        let (m, _) = respond(&grating, o, i, Part::Discrete(place as u32));
        assert!((m.x_axis.x - 0.3).abs() < 1e-6 && order.share(&[1.0; ENVELOPES]) > 0.0);
    }
}

#[test]
fn envelopes_say_where() {
    let m = json!([[0.8, 0, 0, 0], [0, 0, 0, 0], [0, 0, 0, 0], [0, 0, 0, 0]]);
    let spot = matter(json!({"populations": [
        {"M": m, "R": {"kind": "gaussian", "S": [[1e-12, 0], [0, 1e-12]]}, "I": {"kind": "gaussian", "S": [[1e-4, 0], [0, 4e-4]]}},
    ]}))
    .unwrap();
    let o = toward(10.0, 0.0);
    let at = |position: Vec3A| {
        let vertex = Vertex {
            position,
            ..vertex(o)
        };
        let (response, _) = spot.respond::<Polarized<1>>(
            &vertex,
            toward(12.0, 180.0),
            Part::Continuous,
            &[550.0],
            &Coherence::PLANE_WAVE,
        );
        let MuellerResponse::General { matrices: [m], .. } = response else {
            panic!()
        };
        m.x_axis.x
    };
    let ratio = at(Vec3A::new(0.01, 0.02, 0.0)) / at(Vec3A::ZERO);
    assert!((f64::from(ratio) - (-1f64).exp()).abs() < 1e-5, "{ratio}");
}

#[test]
fn what_is_no_matter_is_refused() {
    let gaussian = json!({"kind": "gaussian", "S": [[1e-12, 0], [0, 1e-12]]});
    let wide = json!({"kind": "gaussian", "S": [[4e-12, 0], [0, 4e-12]]});
    for (population, expected) in [
        (
            json!({"M": [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, -1]], "R": gaussian}),
            "key 'populations[0].M': Mueller matrix: eigenvalue 3 of its coherency matrix is -0.5",
        ),
        (
            json!({"R": [[gaussian, null, null, null], [null, wide, null, null], [null, null, null, null], [null, null, null, null]]}),
            "key 'populations': matter: Mueller matrix: eigenvalue 3 of its coherency matrix is",
        ),
        (
            json!({"T": [[1, 0], [0, 1]], "R": {"kind": "gaussian_sum", "weights": [2], "S_list": [[[1e-12, 0], [0, 1e-12]]]}}),
            "key 'populations': the matter scatters up to 2 of the light that meets it, expected at most 1; multiply every 'amp' by 0.5",
        ),
        (
            json!({"T": [[1, 0], [0, 1]]}),
            "key 'populations[0].R' is missing, expected an autocorrelation",
        ),
        (
            json!({"R": gaussian}),
            "key 'populations[0].R': found one autocorrelation without a matrix, expected 'T', 'M' or 'sixteen'",
        ),
        (
            json!({"T": [[1, 0], [0, 1]], "R": {"kind": "gausian"}}),
            "key 'populations[0].R.kind': found 'gausian', expected 'constant'",
        ),
        (
            json!({"T": [[1, 0], [0, 1]], "R": gaussian, "sdie": "x"}),
            "key 'populations[0].sdie': found an unknown key, did you mean 'side'?",
        ),
        (
            json!({"T": [[1, 0], [0, 1]], "R": {"kind": "constant", "apm": 1}}),
            "key 'populations[0].R.apm': found an unknown key, did you mean 'amp'?",
        ),
        (
            json!({"T": [[1, 0], [0, 1]], "R": {"kind": "relief", "phi_z": 2e7, "relief":
                {"kind": "grating", "pitch": 2e-6, "profile": {"kind": "blazed", "depth": 3e-7, "sense": "rising"}}}}),
            "key 'populations[0].R.relief.kind': found a grating, which has sharp orders without end, expected other",
        ),
        (
            json!({"T": [[1, 0], [0, 1]], "R": gaussian, "side": "back"}),
            "key 'populations[0].side': found 'back', expected 'reflection' or 'transmission'",
        ),
    ] {
        let error = matter(json!({"populations": [population]})).unwrap_err();
        assert!(error.starts_with(expected), "{error}");
    }
    assert_eq!(
        matter(json!({"populations": []})).unwrap_err(),
        "key 'populations': found no population, expected at least one"
    );
}
