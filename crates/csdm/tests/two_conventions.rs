//! Light in the phase convention of the renderer, `e^{+ikr}`, and fields in `exp(+iωt)` tell the same story of an
//! element: `Σ^(j→l) = M_lj*` acts on the one as `⟨T C T†⟩` acts on the other.

use csdm::{CrossSpectralDensity, Element, JonesMatrix, PhaseScreen, Sequence, Varying};
use nalgebra::{Matrix2, Vector2, Vector3, Vector4};
use num_complex::Complex64;
use proptest::prelude::*;
use stokes::{Components, Frame, GeneralizedStokes, HermiteSeries, ShapeMatrix, Wavelength};

fn complex(re: f64, im: f64) -> Complex64 {
    Complex64::new(re, im)
}

/// Light with another skew mode in each component: nothing in it is real away from zero separation.
fn light() -> GeneralizedStokes {
    let series = |c00: f64, c10: f64, c01: f64| {
        let modes = [
            (0, 0, complex(c00, 0.0)),
            (1, 0, complex(0.0, c10)),
            (0, 1, complex(0.0, c01)),
        ];
        Some(HermiteSeries::from_modes(&modes).expect("even orders real, odd ones imaginary"))
    };
    GeneralizedStokes::new(
        Components::Separate([
            series(1.0, 0.4, -0.1),
            series(0.2, 0.1, 0.3),
            series(-0.1, 0.0, 0.2),
            series(-0.3, 0.2, 0.0),
        ]),
        ShapeMatrix::from_root(&Matrix2::from_diagonal_element(1e-3)).expect("round"),
        Frame::with_x_along(Vector3::z(), Vector3::x()).expect("not parallel"),
        Wavelength::from_metres(500e-9).expect("positive"),
        2.0,
    )
    .expect("in the far field")
}

/// A pattern of phases, axes and losses that has no symmetry, and a random screen behind it.
fn element() -> impl Element {
    let pattern = Varying::new(|r: &Vector2<f64>| {
        let (x, y) = (r.x / 1e-3, r.y / 1e-3);
        JonesMatrix::homogeneous(x, 0.3 * y, Complex64::cis(2.0 * y), complex(0.4, x))
    });
    let screen = PhaseScreen::independent([0.4, 0.9], [1e-3, 2e-3]).expect("possible");
    Sequence::new().then(pattern).then(screen)
}

proptest! {
    #[test]
    fn scattering_functions_act_on_light_as_jones_matrices_act_on_fields(
        first in prop::array::uniform2(-1e-3..1e-3f64), second in prop::array::uniform2(-1e-3..1e-3f64),
    ) {
        let (light, element) = (light(), element());
        let (first, second) = (Vector2::from(first), Vector2::from(second));
        let separation = first - second;
        let fields = CrossSpectralDensity::of_light(&light, &separation).unwrap();
        let by_fields = element.act_on(&fields, &first, &second);
        let scattering = element.generalized_mueller(&first, &second).scattering();
        let by_scattering = scattering * Vector4::from(light.at_separation(&separation));
        // the parameters C_l(ξ₁, ξ₂) of light are those of ⟨E(ξ₂) E(ξ₁)†⟩
        let found = Vector4::from(by_fields.exchanged().generalized_stokes());
        prop_assert!((found - by_scattering).norm() < 1e-14 * by_scattering.norm().max(fields.to_matrix().norm()));
    }
}

#[test]
fn without_the_conjugate_the_two_disagree() {
    let (light, element) = (light(), element());
    let (first, second) = (Vector2::new(3e-4, 1e-4), Vector2::new(-5e-4, 4e-4));
    let separation = first - second;
    let fields = CrossSpectralDensity::of_light(&light, &separation).unwrap();
    let by_fields = element.act_on(&fields, &first, &second).exchanged();
    let without = element.generalized_mueller(&first, &second).to_matrix()
        * Vector4::from(light.at_separation(&separation));
    let found = Vector4::from(by_fields.generalized_stokes());
    assert!((found - without).norm() > 0.3 * found.norm());
}
