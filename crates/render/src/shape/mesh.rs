//! Triangle meshes in world space: all meshes of a scene in one list of triangles.

use glam::{DMat3, DMat4, DVec3, Vec3A};

use super::{AreaSample, Surface, by_area, solid_angle_density};
use crate::geometry::bvh::Bounds;
use crate::geometry::frame::Frame;
use crate::geometry::ray::gamma;
use crate::lights::Bundle;
use crate::scene::mesh::{Mesh, vertex_normals};

/// A mesh placed in the world.
#[derive(Debug)]
pub struct PlacedMesh {
    positions: Vec<Vec3A>,
    normals: Option<Vec<Vec3A>>,
    texcoords: Option<Vec<[f32; 2]>>,
    triangles: Vec<[u32; 3]>,
    /// +1, or −1 for `flip_normals`.
    side: f32,
    /// Sums of triangle areas, for choosing a point by area; empty unless the mesh emits.
    cumulative_area: Vec<f64>,
}

impl PlacedMesh {
    /// Transforms a mesh into the world. Smooth normals are computed there if the file has none and `face_normals` is
    /// not asked for.
    ///
    /// The front is where the file's normals point. Where they are not used it is the side from which the corners run
    /// counter-clockwise in the world, as in Mitsuba 3: a mirroring transform then turns the mesh inside out.
    pub fn new(
        mut mesh: Mesh,
        to_world: &DMat4,
        face_normals: bool,
        flip_normals: bool,
        emits: bool,
    ) -> Self {
        for p in &mut mesh.positions {
            *p = to_world
                .transform_point3(glam::Vec3::from(*p).as_dvec3())
                .as_vec3()
                .to_array();
        }
        let normals: Option<Vec<Vec3A>> = match mesh.normals.take().filter(|_| !face_normals) {
            Some(normals) => {
                if to_world.determinant() < 0.0 {
                    // the first two corners: axis U stays along the edge between them
                    mesh.triangles.iter_mut().for_each(|t| t.swap(0, 1));
                }
                let covectors = DMat3::from_mat4(*to_world).inverse().transpose();
                let turned = |n| {
                    (covectors * glam::Vec3::from(n).as_dvec3())
                        .normalize_or_zero()
                        .as_vec3a()
                };
                Some(normals.into_iter().map(turned).collect())
            }
            None if face_normals => None,
            None => Some(vertex_normals(&mesh).into_iter().map(Vec3A::from).collect()),
        };
        let positions = mesh.positions.into_iter().map(Vec3A::from).collect();
        let triangles = mesh.triangles;
        let mut placed = Self {
            positions,
            normals,
            texcoords: mesh.texcoords,
            triangles,
            side: if flip_normals { -1.0 } else { 1.0 },
            cumulative_area: Vec::new(),
        };
        if emits {
            let mut sum = 0.0;
            placed.cumulative_area = (0..placed.len())
                .map(|i| {
                    let [a, b, c] = placed.corners(i).map(Vec3A::as_dvec3);
                    sum += 0.5 * (b - a).cross(c - a).length();
                    sum
                })
                .collect();
        }
        placed
    }

    /// Number of triangles.
    pub fn len(&self) -> usize {
        self.triangles.len()
    }

    /// Whether it has no triangle at all.
    pub fn is_empty(&self) -> bool {
        self.triangles.is_empty()
    }

    /// Largest absolute coordinate of any vertex, metres.
    pub fn reach(&self) -> f32 {
        self.positions.iter().fold(0.0, |reach, p| {
            let largest = p.abs().max_element();
            // NaN and infinity count as out of reach
            if largest <= reach { reach } else { largest }
        })
    }

    /// Area of the whole, m²; 0 unless it emits.
    pub fn area(&self) -> f64 {
        self.cumulative_area.last().copied().unwrap_or(0.0)
    }

    /// It as a light source of a given radiance, seen from afar.
    pub fn glance(&self, radiance: f64) -> Bundle {
        let triangles = || (0..self.len()).map(|triangle| self.corners(triangle));
        let bounds = Bounds::of(triangles().flatten());
        let vectors = || {
            triangles().map(|corners| {
                let [a, b, c] = corners.map(Vec3A::as_dvec3);
                (b - a).cross(c - a) * (0.5 * f64::from(self.side))
            })
        };
        let sum: DVec3 = vectors().sum();
        // from far along its mean normal a flat mesh shows all of its area, a closed one from everywhere a quarter
        let shown = sum.length().max(0.25 * self.area());
        let spread = sum.try_normalize().map_or(std::f64::consts::PI, |axis| {
            vectors().fold(0.0, |spread: f64, vector| {
                spread.max(axis.cross(vector).length().atan2(axis.dot(vector)))
            })
        });
        Bundle {
            spread: spread as f32,
            ..Bundle::facing(
                sum.normalize_or(DVec3::Z).as_vec3a(),
                bounds,
                radiance * shown,
            )
        }
    }

    /// The corners of a triangle.
    #[inline]
    pub fn corners(&self, triangle: usize) -> [Vec3A; 3] {
        self.triangles[triangle].map(|i| self.positions[i as usize])
    }

    /// The surface at barycentric weights (1 − u − v, u, v) of a triangle.
    #[inline]
    pub fn surface(&self, triangle: usize, u: f32, v: f32) -> Surface {
        let [a, b, c] = self.corners(triangle);
        let w = 1.0 - u - v;
        let normal = (b - a).cross(c - a).normalize_or_zero() * self.side;
        let shading = self.shading_normal(triangle, [w, u, v]).unwrap_or(normal);
        Surface {
            position: a * w + b * u + c * v,
            error: ((a * w).abs() + (b * u).abs() + (c * v).abs()) * gamma(7),
            normal,
            frame: Frame::with_tangent(shading, self.tangent(triangle)),
        }
    }

    #[inline]
    fn shading_normal(&self, triangle: usize, weights: [f32; 3]) -> Option<Vec3A> {
        let normals = self.normals.as_ref()?;
        let [a, b, c] = self.triangles[triangle].map(|i| normals[i as usize]);
        (a * weights[0] + b * weights[1] + c * weights[2])
            .try_normalize()
            .map(|n| n * self.side)
    }

    /// Direction of growing first texture coordinate, or of the first edge.
    #[inline]
    fn tangent(&self, triangle: usize) -> Vec3A {
        let [a, b, c] = self.corners(triangle);
        if let Some(texcoords) = &self.texcoords {
            let [ta, tb, tc] = self.triangles[triangle].map(|i| texcoords[i as usize]);
            let (du1, dv1) = (tb[0] - ta[0], tb[1] - ta[1]);
            let (du2, dv2) = (tc[0] - ta[0], tc[1] - ta[1]);
            let det = du1 * dv2 - dv1 * du2;
            if det != 0.0 {
                return ((b - a) * dv2 - (c - a) * dv1) * det.signum();
            }
        }
        b - a
    }

    /// A point uniform over the area, as seen from `reference`; `None` if the mesh has no area.
    pub fn sample(&self, reference: Vec3A, u: [f32; 2]) -> Option<AreaSample> {
        let total = self.area();
        if total <= 0.0 {
            return None;
        }
        let target = f64::from(u[0]) * total;
        let triangle = self
            .cumulative_area
            .partition_point(|&sum| sum <= target)
            .min(self.len() - 1);
        let below = if triangle > 0 {
            self.cumulative_area[triangle - 1]
        } else {
            0.0
        };
        let fraction =
            ((target - below) / (self.cumulative_area[triangle] - below)).clamp(0.0, 1.0) as f32;
        let root = fraction.sqrt();
        let at = self.surface(triangle, root * (1.0 - u[1]), root * u[1]);
        by_area((at.position, at.error, at.normal), total as f32, reference)
    }

    /// Density of [`PlacedMesh::sample`], per steradian.
    pub fn pdf(&self, reference: Vec3A, at: &Surface) -> f32 {
        solid_angle_density(self.area() as f32, reference, at.position, at.normal)
    }
}
