//! Who hears of the light that a path collects: nobody, or sums from which the light's coherence follows.
//!
//! At a pinhole all light of a pixel is a single cone, whatever the scene. So coherence is told where the light meets
//! matter: at the first vertex on the way of the pixel's ray that is not specular, in its tangent plane. A bare sensor plane
//! is such a vertex itself. With the weight w
//! of a contribution (its S0 at the sensor), the tangential part θ of the direction toward the light, the angular root Ω
//! of its patch there and the wavenumber k,
//!
//! ```text
//! W = Σ w     m = Σ w kθ     M = Σ w k² (θθᵀ + ΩᵀΩ)     G(ξ) = Σ w exp(−ikθ·ξ) exp(−½ k² ξᵀΩᵀΩ ξ)
//! Γ = M/W − m mᵀ/W²          semi-axes of the coherence ellipse 1/√eig Γ          degree of coherence |G(ξ)|/W
//! ```
//!
//! The moments of patches are those of the emitter: Γ does not depend on how it is cut.
//!
//! Source: van Cittert-Zernike theorem, Born and Wolf, Principles of Optics, 7th ed., section 10.4.2.

use glam::{DVec2, Vec3A, Vec4, dvec2};
use stokes::CoherenceEllipse;

use crate::coherence::Coherence;

/// What is told of a camera path. Whoever does not listen, `()`, costs nothing.
pub trait Witness {
    /// The path meets matter that is not specular; `normal` is on the camera's side, `index` that of the medium there.
    #[inline]
    fn meets(&mut self, _normal: Vec3A, _index: f32) {}

    /// It goes on from any matter toward the light.
    #[inline]
    fn departs(&mut self, _from: Vec3A, _to: Vec3A, _reflected: bool) {}

    /// It collects light, Stokes vectors at the sensor, times `weight`; `arrival` is the direction toward the light and
    /// its coherence at the last vertex, if that is not the direction in which the path has left it.
    #[inline]
    fn hears(&mut self, _light: &[Vec4], _weight: f32, _arrival: Option<(Vec3A, Coherence)>) {}
}

impl Witness for () {}

/// Sums over contributions, which determine the coherence of their light.
///
/// Angular frequencies kθ in 1/m, in the tangent frame of the vertex.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CoherenceSums {
    /// `[W, m_x, m_y, M_xx, M_xy, M_yy, Re G, Im G]`
    sums: [f64; 8],
}

/// A spread of directions below this share of their squares is rounding: the light is coherent.
const ROUNDING: f64 = 1e-13;

impl CoherenceSums {
    /// One contribution: weight, mean kθ, covariance of kθ (xx, xy, yy), and the separation of the degree.
    #[inline]
    fn add(&mut self, w: f64, mean: DVec2, [xx, xy, yy]: [f64; 3], separation: DVec2) {
        let (sin, cos) = mean.dot(separation).sin_cos();
        let (x, y) = (separation.x, separation.y);
        let fall = (-0.5 * (xx * x * x + 2.0 * xy * x * y + yy * y * y)).exp();
        let terms = [
            1.0,
            mean.x,
            mean.y,
            mean.x * mean.x + xx,
            mean.x * mean.y + xy,
            mean.y * mean.y + yy,
            cos * fall,
            -sin * fall,
        ];
        for (sum, term) in self.sums.iter_mut().zip(terms) {
            *sum += w * term;
        }
    }

    /// Adds the sums of a sample. What is not finite is left out whole.
    #[inline]
    pub fn merge(&mut self, other: &Self) {
        if other.sums.iter().all(|v| v.is_finite()) {
            for (sum, more) in self.sums.iter_mut().zip(other.sums) {
                *sum += more;
            }
        }
    }

    /// The coherence ellipse, its angle counter-clockwise from the frame's first axis, and the degree of coherence.
    ///
    /// `None` without light. Semi-axes in metres, infinite for light of a single direction.
    pub fn coherence(&self) -> Option<(CoherenceEllipse, f64)> {
        let [w, moments @ ..] = self.sums;
        if w <= 0.0 {
            return None;
        }
        let [mx, my, xx, xy, yy, re, im] = moments.map(|sum| sum / w);
        let (a, b, d) = (xx - mx * mx, xy - mx * my, yy - my * my);
        let (middle, half) = (0.5 * (a + d), (0.5 * (a - d)).hypot(b));
        let least = ROUNDING * (xx + yy);
        let width = |spread: f64| {
            if spread > least {
                spread.sqrt().recip()
            } else {
                f64::INFINITY
            }
        };
        let widest_spread = middle + half;
        // the wider the spread of directions, the shorter the coherence
        let orientation = if half > least {
            (0.5 * (2.0 * b).atan2(a - d) + std::f64::consts::FRAC_PI_2)
                .rem_euclid(std::f64::consts::PI)
        } else {
            0.0
        };
        let ellipse = CoherenceEllipse {
            semi_major: width(middle - half),
            semi_minor: width(widest_spread),
            orientation,
        };
        Some((ellipse, re.hypot(im)))
    }
}

/// A view from the middle of a pixel.
#[derive(Clone, Copy, Debug)]
pub struct View {
    /// Viewing direction; of a bare sensor plane its normal.
    pub direction: Vec3A,
    /// Image right, across it.
    pub right: Vec3A,
    /// Root of the covariance of directions over the pixel: the pixel's own patch of what it sees directly.
    pub root: [Vec3A; 2],
}

/// Adds up the coherence of the light of one camera sample.
#[derive(Clone, Debug)]
pub struct Listener<'a> {
    /// Of each lane: vacuum wavenumber in 1/m, and weight.
    lanes: &'a [(f64, f64)],
    separation: DVec2,
    /// Image right and up, carried along with the ray through specular matter.
    image: [Vec3A; 2],
    /// The frame in which directions are told: the sensor's, later that of the first vertex.
    axes: [Vec3A; 2],
    index: f64,
    /// Direction and coherence of light that says nothing else.
    own: (Vec3A, Coherence),
    /// Vertices that are not specular so far.
    vertices: u32,
    /// Whether the path has left the first of them.
    left: bool,
    /// What it has heard.
    pub sums: CoherenceSums,
}

impl<'a> Listener<'a> {
    /// Before the path begins; `separation` is in metres along the first and the second axis of the frame.
    pub fn new(view: &View, lanes: &'a [(f64, f64)], separation: [f64; 2]) -> Self {
        let direction = view.direction;
        let image = [view.right, view.right.cross(direction)];
        Self {
            lanes,
            separation: DVec2::from_array(separation),
            image,
            axes: image,
            index: 1.0,
            own: (
                direction,
                Coherence {
                    angular_root: view.root,
                    distance: f32::INFINITY,
                },
            ),
            vertices: 0,
            left: false,
            sums: CoherenceSums::default(),
        }
    }
}

/// What becomes of a vector when its ray turns from `from` to `to`: as an image in a mirror, or by the least rotation.
fn carried(v: Vec3A, from: Vec3A, to: Vec3A, reflected: bool) -> Vec3A {
    if reflected {
        let normal = (to - from).normalize_or_zero();
        return v - normal * (2.0 * normal.dot(v));
    }
    let turn = from.cross(to);
    let twice = turn.cross(turn.cross(v));
    v + turn.cross(v) + twice / (1.0 + from.dot(to)).max(1e-6)
}

/// Two axes across a normal that look like image right and, as far as it goes, image up.
fn tangent([right, up]: [Vec3A; 2], normal: Vec3A) -> [Vec3A; 2] {
    let across = |v: Vec3A| v - normal * normal.dot(v);
    let first = across(right)
        .try_normalize()
        .unwrap_or_else(|| across(up).normalize_or_zero());
    let second = normal.cross(first);
    // behind an odd number of mirrors the image is mirrored, and its up with it
    [
        first,
        if second.dot(up) < 0.0 {
            -second
        } else {
            second
        },
    ]
}

impl Witness for Listener<'_> {
    fn meets(&mut self, normal: Vec3A, index: f32) {
        if self.vertices == 0 {
            self.axes = tangent(self.image, normal);
            self.index = f64::from(index);
        }
        self.vertices += 1;
    }

    fn departs(&mut self, from: Vec3A, to: Vec3A, reflected: bool) {
        if self.vertices == 0 {
            self.image = self.image.map(|v| carried(v, from, to, reflected));
        } else if !self.left {
            self.own = (to, Coherence::PLANE_WAVE);
            self.left = true;
        }
    }

    fn hears(&mut self, light: &[Vec4], weight: f32, arrival: Option<(Vec3A, Coherence)>) {
        let (direction, coherence) = arrival.filter(|_| self.vertices == 1).unwrap_or(self.own);
        let along = |v: Vec3A| {
            dvec2(
                f64::from(v.dot(self.axes[0])),
                f64::from(v.dot(self.axes[1])),
            ) * self.index
        };
        let theta = along(direction);
        let [p, q] = coherence.angular_root.map(along);
        let spread = [
            p.x * p.x + q.x * q.x,
            p.x * p.y + q.x * q.y,
            p.y * p.y + q.y * q.y,
        ];
        for (stokes, &(k, share)) in light.iter().zip(self.lanes) {
            let w = f64::from(stokes.x) * f64::from(weight) * share;
            if w != 0.0 {
                self.sums
                    .add(w, theta * k, spread.map(|s| s * k * k), self.separation);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::emitter::patch::{Cut, Outline};

    const K: f64 = 1.142e7;

    fn view(direction: Vec3A) -> View {
        View {
            direction,
            right: Vec3A::X,
            root: [Vec3A::X * 1e-3, Vec3A::Y * 2e-3],
        }
    }

    /// A disk of angular diameter `a`, inclined to the plane below it, cut as finely as asked.
    fn under_a_disk(a: f32, largest: f32, separation: [f64; 2]) -> (CoherenceEllipse, f64) {
        let outline = Outline {
            centre: Vec3A::Z,
            half_u: Vec3A::X * (0.5 * a),
            half_v: Vec3A::Y * (0.5 * a),
            normal: Vec3A::NEG_Z,
            round: true,
            error: Vec3A::ZERO,
        };
        let cut = Cut::flat(outline, Vec3A::ZERO, largest).expect("from the front");
        let lanes = [(K, 1.0)];
        let mut listener = Listener::new(&view(Vec3A::NEG_Z), &lanes, separation);
        listener.meets(Vec3A::Z, 1.0);
        for patch in (0..cut.len()).map(|i| cut.patch(i)) {
            let arrival = Some((patch.direction, patch.coherence()));
            listener.hears(&[Vec4::X], patch.solid_angle, arrival);
        }
        listener.sums.coherence().expect("light")
    }

    #[test]
    fn the_ellipse_does_not_depend_on_the_cut() {
        let a = 0.02f32;
        let radius = 4.0 / (K * f64::from(a));
        // of one patch, and of about a thousand
        for largest in [1.0, 0.003, 0.0006] {
            let (ellipse, _) = under_a_disk(a, largest, [0.0; 2]);
            // tangents for sines: a² of the spread
            let off = [ellipse.semi_major, ellipse.semi_minor].map(|l| (l / radius - 1.0).abs());
            assert!(off[0].max(off[1]) < 3e-4, "{largest}: {off:?}");
        }
        // u = 2: 2 J1(u)/u; of one patch it is the Gaussian of the same spread
        let separation = [0.0, 4.0 / (K * f64::from(a))];
        let (_, degree) = under_a_disk(a, 0.0006, separation);
        assert!((degree - 0.576_724_8).abs() < 1e-3, "{degree}");
        let (_, degree) = under_a_disk(a, 1.0, separation);
        assert!((degree - (-0.5f64).exp()).abs() < 1e-3, "{degree}");
    }

    #[test]
    fn later_vertices_do_not_count_and_the_index_does() {
        let lanes = [(K, 1.0)];
        let mut listener = Listener::new(&view(Vec3A::NEG_Z), &lanes, [0.0; 2]);
        listener.meets(Vec3A::Z, 1.5);
        let spread = |listener: &Listener<'_>| listener.sums.coherence().expect("light").0;
        let tilt = |x: f32| Vec3A::new(x, 0.0, (1.0 - x * x).sqrt());
        listener.hears(&[Vec4::X], 1.0, Some((tilt(0.01), Coherence::PLANE_WAVE)));
        listener.departs(Vec3A::NEG_Z, tilt(-0.01), true);
        listener.meets(Vec3A::X, 1.0);
        // the direction at the second vertex is another matter
        listener.hears(&[Vec4::X], 1.0, Some((Vec3A::Y, Coherence::PLANE_WAVE)));
        let ellipse = spread(&listener);
        // two directions ± 0.01 in a medium of index 1.5
        assert!((ellipse.semi_minor * 1.5 * K * 0.01 - 1.0).abs() < 1e-5);
        assert_eq!(ellipse.semi_major, f64::INFINITY);
        assert!((ellipse.orientation - 0.5 * std::f64::consts::PI).abs() < 1e-9);
    }

    #[test]
    fn an_oblique_spread_has_an_oblique_ellipse_and_its_own_fall() {
        let lanes = [(K, 1.0)];
        let separation = [3e-5, 2e-5];
        let mut listener = Listener::new(&view(Vec3A::NEG_Z), &lanes, separation);
        listener.meets(Vec3A::Z, 1.0);
        let coherence = Coherence {
            angular_root: [Vec3A::new(3e-3, 1e-3, 0.0), Vec3A::new(1e-3, 2e-3, 0.0)],
            distance: 1.0,
        };
        let toward = Vec3A::new(0.01, 0.02, 0.999_75);
        listener.hears(&[Vec4::X], 1.0, Some((toward, coherence)));
        let (ellipse, degree) = listener.sums.coherence().expect("light");
        // ΩᵀΩ = (10, 5; 5, 5)·1e-6, whatever the mean direction
        let radius = 2.5f64.hypot(5.0);
        for (found, spread) in [
            (ellipse.semi_minor, 7.5 + radius),
            (ellipse.semi_major, 7.5 - radius),
        ] {
            let expected = 1.0 / (K * (spread * 1e-6).sqrt());
            // Ω in single precision, of which squares of the mean 100 times larger are taken off
            assert!((found / expected - 1.0).abs() < 1e-5, "{found} {expected}");
        }
        let widest = 0.5 * 10.0f64.atan2(5.0);
        let across = widest + 0.5 * std::f64::consts::PI;
        assert!((ellipse.orientation - across).abs() < 1e-5, "{ellipse:?}");
        let [x, y] = separation;
        let exponent = 0.5 * K * K * 1e-6 * (10.0 * x * x + 10.0 * x * y + 5.0 * y * y);
        assert!((degree - (-exponent).exp()).abs() < 1e-6, "{degree}");
    }

    #[test]
    fn wavelengths_count_by_their_shares() {
        let lanes = [(K, 1.0), (2.0 * K, 3.0)];
        let mut listener = Listener::new(&view(Vec3A::NEG_Z), &lanes, [0.0; 2]);
        listener.meets(Vec3A::Z, 1.0);
        let toward = Vec3A::new(0.01, 0.0, 0.999_95);
        listener.hears(&[Vec4::X; 2], 0.5, Some((toward, Coherence::PLANE_WAVE)));
        let (ellipse, _) = listener.sums.coherence().expect("light");
        // kθ is 1 with the weight 1 and 2 with the weight 3: variance 3/16
        let expected = 1.0 / ((3.0f64 / 16.0).sqrt() * K * 0.01);
        assert!((ellipse.semi_minor / expected - 1.0).abs() < 1e-6);
    }

    #[test]
    fn axes_are_carried_through_mirrors_and_glass() {
        let (from, to) = (
            Vec3A::new(0.6, 0.0, -0.8),
            Vec3A::new(0.28, 0.0, -0.96).normalize(),
        );
        for reflected in [false, true] {
            let turned = carried(from, from, to, reflected);
            assert!((turned - to).length() < 1e-6, "{reflected}: {turned}");
            assert!((carried(Vec3A::Y, from, to, reflected) - Vec3A::Y).length() < 1e-6);
        }
        // seen from behind the right hand is left
        let [first, second] = tangent([Vec3A::X, Vec3A::Y], Vec3A::new(0.0, -0.6, 0.8));
        assert!((first - Vec3A::X).length() < 1e-6);
        assert!((second - Vec3A::new(0.0, 0.8, 0.6)).length() < 1e-6);
    }

    #[test]
    fn no_light_has_no_coherence_and_broken_samples_are_left_out() {
        let mut sums = CoherenceSums::default();
        assert_eq!(sums.coherence(), None);
        let mut broken = sums;
        broken.add(f64::NAN, DVec2::ZERO, [0.0; 3], DVec2::ZERO);
        sums.merge(&broken);
        assert_eq!(sums, CoherenceSums::default());
    }
}
