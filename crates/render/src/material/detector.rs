//! What the plane of a bare sensor is to the paths that begin on it: light counts with its cosine and keeps its polarization.
//!
//! No bsdf of a scene file: sensor `irradiancemeter` is made of it. Light passes from the front into the plane,
//!
//! ```text
//! E = ∫ S(i) cos_i dω_i
//! ```
//!
//! with S in the frame whose first axis is the plane's local x, projected across the ray. Along a ray that is parallel to
//! this axis (within 1e-5) the local y takes its place.

use std::f32::consts::FRAC_1_PI;

use glam::{Mat4, Vec3A, vec2};

use super::{Departure, Effect, Matter, Part, Vertex, dark};
use crate::coherence::Coherence;
use crate::emitter::patch::Outline;
use crate::emitter::polarization::across;
use crate::light::Light;
use crate::sampler::{cosine_hemisphere, unit_disk};
use crate::shape::solid_angle_density;

/// A plane that records the light on its front side.
#[derive(Clone, Debug)]
pub struct Detector {
    /// The only outline through which it sees; `None`: it sees everything in front of it.
    pub toward: Option<Box<Outline>>,
}

impl Detector {
    /// Density per steradian of directions drawn, for local direction `i`.
    fn density(&self, at: &Vertex, i: Vec3A) -> f32 {
        if i.z <= 0.0 {
            return 0.0;
        }
        let Some(window) = &self.toward else {
            return i.z * FRAC_1_PI;
        };
        let direction = at.frame.to_world(i);
        let t = (window.centre - at.position).dot(window.normal) / direction.dot(window.normal);
        if !(t > 0.0 && t.is_finite()) {
            return 0.0;
        }
        let point = at.position + direction * t;
        if window.holds(window.coordinates(point)) {
            solid_angle_density(window.area(), at.position, point, window.normal)
        } else {
            0.0
        }
    }
}

impl Matter for Detector {
    fn sample(&self, at: &Vertex, _: &[f32], u: [f32; 3]) -> Option<Departure> {
        let (direction, density) = match &self.toward {
            None => {
                let i = cosine_hemisphere([u[1], u[2]]);
                (i, i.z * FRAC_1_PI)
            }
            Some(window) => {
                let (x, y) = if window.round {
                    unit_disk([u[1], u[2]])
                } else {
                    (2.0 * u[1] - 1.0, 2.0 * u[2] - 1.0)
                };
                let point = window.at(vec2(x, y));
                let i = at.frame.to_local((point - at.position).normalize());
                let density = solid_angle_density(window.area(), at.position, point, window.normal);
                (i, density)
            }
        };
        (direction.z > 0.0 && density.is_finite()).then_some(Departure {
            direction,
            density,
            part: Part::Continuous,
            eta: 1.0,
        })
    }

    fn respond<L: Light>(
        &self,
        at: &Vertex,
        i: Vec3A,
        _: Part,
        _: &[f32],
        _: &Coherence,
    ) -> (L::Response, f32) {
        let density = self.density(at, i);
        if density <= 0.0 {
            return dark::<L>();
        }
        let matrix = Mat4::IDENTITY * i.z;
        let axis = across(Vec3A::X, Vec3A::Y, i);
        (L::general(Vec3A::X, axis, |_| matrix), density)
    }

    fn effect(&self) -> Effect {
        Effect::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::frame::Frame;
    use crate::light::{MuellerResponse, Polarized, Sight};
    use crate::sampler::SampleStream;

    fn window(round: bool) -> Detector {
        Detector {
            toward: Some(Box::new(Outline {
                centre: Vec3A::new(0.3, -0.1, 1.0),
                half_u: Vec3A::new(0.4, 0.0, 0.1),
                half_v: Vec3A::new(0.0, 0.3, 0.0),
                normal: Vec3A::new(-0.1, 0.0, 0.4).normalize(),
                round,
                error: Vec3A::ZERO,
            })),
        }
    }

    fn vertex() -> Vertex {
        Vertex {
            o: Vec3A::NEG_Z,
            position: Vec3A::new(0.05, 0.02, 0.0),
            frame: Frame::around(Vec3A::new(0.1, 0.2, 0.9).normalize()),
            viewer_distance: 0.0,
            sight: Sight::BLIND,
        }
    }

    /// The mean of 1/density over what is drawn is the solid angle, and respond agrees with sample on the density.
    #[test]
    fn directions_follow_their_density() {
        let at = vertex();
        for (detector, name) in [
            (Detector { toward: None }, "hemisphere"),
            (window(false), "rectangle"),
            (window(true), "disk"),
        ] {
            let n = 20_000;
            let mut inside = 0;
            for k in 0..n {
                let stream = SampleStream::new(5, 0, k);
                let ([a, b], [c, _]) = (stream.pair(0), stream.pair(2));
                let departure = detector.sample(&at, &[], [a, b, c]).expect("in front");
                let density = detector.density(&at, departure.direction);
                // a point of the very edge may be rounded out
                if density > 0.0 {
                    inside += 1;
                    assert!(
                        (density / departure.density - 1.0).abs() < 1e-4,
                        "{name}: {density} {}",
                        departure.density
                    );
                }
            }
            assert!(inside > n - 10, "{name}: {inside}");
            // over the hemisphere the density integrates to 1
            let (steps, mut sum) = (400, 0.0);
            for row in 0..steps {
                for column in 0..steps {
                    let z = (row as f32 + 0.5) / steps as f32;
                    let phi = std::f32::consts::TAU * (column as f32 + 0.5) / steps as f32;
                    let r = (1.0 - z * z).sqrt();
                    let i = Vec3A::new(r * phi.cos(), r * phi.sin(), z);
                    sum += f64::from(detector.density(&at, i));
                }
            }
            let whole = sum * std::f64::consts::TAU / f64::from(steps * steps);
            // cells at the edge: at most 4 · 400 of about 4,000, each off by half of itself at random
            assert!((whole - 1.0).abs() < 0.01, "{name}: {whole}");
        }
    }

    #[test]
    fn light_from_behind_and_from_beside_the_window_is_not_recorded() {
        let at = vertex();
        let seen = |detector: &Detector, toward: Vec3A| {
            let i = at.frame.to_local((toward - at.position).normalize());
            detector.density(&at, i) > 0.0
        };
        let everything = Detector { toward: None };
        assert!(seen(&everything, Vec3A::new(3.0, 0.0, 1.0)));
        assert!(!seen(&everything, Vec3A::new(0.0, 0.0, -1.0)));
        let corner = Vec3A::new(0.65, 0.15, 1.087);
        assert!(seen(&window(false), corner));
        assert!(!seen(&window(true), corner));
        assert!(!seen(&window(false), Vec3A::new(0.9, 0.0, 1.0)));
        // the window's mirror image at the point lies behind the plane
        let behind = at.position * 2.0 - Vec3A::new(0.3, -0.1, 1.0);
        assert!(!seen(&window(false), behind));
    }

    #[test]
    fn the_frame_is_the_planes_x_projected_across_the_ray() {
        let at = vertex();
        let i = Vec3A::new(0.6, 0.0, 0.8);
        let (response, density) = Detector { toward: None }.respond::<Polarized<1>>(
            &at,
            i,
            Part::Continuous,
            &[550.0],
            &Coherence::PLANE_WAVE,
        );
        assert!((density - 0.8 * FRAC_1_PI).abs() < 1e-6);
        let MuellerResponse::General {
            axis_out,
            axis_in,
            matrices,
        } = response
        else {
            panic!("a general matrix expected");
        };
        assert_eq!(axis_out, Vec3A::X);
        assert!((axis_in - Vec3A::new(0.8, 0.0, -0.6)).length() < 1e-6);
        assert_eq!(matrices[0], Mat4::IDENTITY * 0.8);
    }
}
