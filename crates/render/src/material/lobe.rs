//! Matter for tests: a Gaussian lobe about the mirror direction, whose average over a patch of light is known exactly.
//!
//! BRDF `a N(i_t + o_t; w² 1)` with the normal density N over tangential directions; light with the angular root Ω is
//! answered with the covariance `w² 1 + Ω_tᵀ Ω_t`. A part of the light may pass straight through.

use glam::{Mat2, Vec2, Vec3A};

use super::{Departure, Effect, Matter, Part, Traits, Vertex, axis_s, dark};
use crate::coherence::Coherence;
use crate::light::{Element, Light};

/// A Gaussian lobe.
#[derive(Clone, Copy, Debug)]
pub struct Lobe {
    /// Standard deviation of the tangential direction.
    pub width: f32,
    /// Reflected fraction.
    pub albedo: f32,
    /// Fraction that passes straight through.
    pub straight: f32,
}

impl Lobe {
    fn density(mean: Vec2, covariance: Mat2) -> f32 {
        let exponent = -0.5 * mean.dot(covariance.inverse() * mean);
        exponent.exp() / (std::f32::consts::TAU * covariance.determinant().sqrt())
    }

    /// Probability of the continuous part.
    fn scatters(&self) -> f32 {
        if self.straight > 0.0 { 0.5 } else { 1.0 }
    }
}

fn tangential(v: Vec3A) -> Vec2 {
    Vec2::new(v.x, v.y)
}

impl Matter for Lobe {
    fn sample(&self, at: &Vertex, _: &[f32], u: [f32; 3]) -> Option<Departure> {
        if u[0] >= self.scatters() {
            return Some(Departure {
                direction: -at.o,
                density: 1.0 - self.scatters(),
                part: Part::Straight,
                eta: 1.0,
            });
        }
        let radius = self.width * (-2.0 * (1.0 - u[1]).ln()).sqrt();
        let offset = Vec2::from_angle(std::f32::consts::TAU * u[2]) * radius;
        let across = offset - tangential(at.o);
        let z = 1.0 - across.length_squared();
        let direction = Vec3A::new(across.x, across.y, z.max(0.0).sqrt());
        let variance = Mat2::from_diagonal(Vec2::splat(self.width * self.width));
        (at.o.z > 0.0 && z > 0.0).then(|| Departure {
            direction,
            density: self.scatters() * Self::density(offset, variance) * direction.z,
            part: Part::Continuous,
            eta: 1.0,
        })
    }

    fn respond<L: Light>(
        &self,
        at: &Vertex,
        i: Vec3A,
        part: Part,
        _: &[f32],
        coherence: &Coherence,
    ) -> (L::Response, f32) {
        let element = Element {
            mean: 1.0,
            difference: 0.3,
            cosine: 0.9,
            sine: 0.2,
        };
        if part == Part::Straight {
            let axis = crate::geometry::frame::Frame::around(at.o).s;
            let clear = Element {
                mean: self.straight,
                difference: 0.0,
                cosine: self.straight,
                sine: 0.0,
            };
            return (L::diattenuating_retarder(axis, |_| clear), 0.0);
        }
        if at.o.z <= 0.0 || i.z <= 0.0 {
            return dark::<L>();
        }
        let mean = tangential(i) + tangential(at.o);
        let own = Mat2::from_diagonal(Vec2::splat(self.width * self.width));
        let light = coherence.angular_root.iter().fold(own, |sum, row| {
            let row = tangential(at.frame.to_local(*row));
            sum + Mat2::from_cols(row * row.x, row * row.y)
        });
        let value = self.albedo * Self::density(mean, light) * i.z;
        let axis = axis_s((at.o + i).normalize(), i);
        (
            L::diattenuating_retarder(axis, |_| element.scaled(value)),
            self.scatters() * Self::density(mean, own) * i.z,
        )
    }

    fn effect(&self) -> Effect {
        Effect::default()
    }

    fn lobe_width(&self, _: &Vertex, _: &[f32]) -> Option<f32> {
        (self.albedo > 0.0).then_some(self.width)
    }

    fn traits(&self) -> Traits {
        Traits {
            straight: self.straight > 0.0,
            coherent: true,
            disperses: false,
            ..Traits::default()
        }
    }
}
