//! The scenes: a tessellated ball in a room, and a Cornell box.

use glam::Vec3A;

/// Triangles as three corners each.
pub type Mesh = Vec<[Vec3A; 3]>;

/// Where rays start and where the light is.
pub struct Scene {
    pub name: String,
    pub mesh: Mesh,
    pub eye: Vec3A,
    pub aim: Vec3A,
    /// Tangent of half the field of view.
    pub tangent: f32,
    /// Centre and half edge of a horizontal square.
    pub light: (Vec3A, f32),
}

fn quad(mesh: &mut Mesh, [a, b, c, d]: [Vec3A; 4]) {
    mesh.extend([[a, b, c], [a, c, d]]);
}

/// A box turned about the vertical.
fn cuboid(mesh: &mut Mesh, centre: Vec3A, half: Vec3A, angle: f32) {
    let (s, c) = angle.sin_cos();
    let corner = |x: f32, y: f32, z: f32| {
        let p = Vec3A::new(x, y, z) * half;
        centre + Vec3A::new(c * p.x + s * p.z, p.y, c * p.z - s * p.x)
    };
    for sign in [-1.0, 1.0] {
        let square = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
        quad(mesh, square.map(|(a, b)| corner(sign, a, b)));
        quad(mesh, square.map(|(a, b)| corner(a, sign, b)));
        quad(mesh, square.map(|(a, b)| corner(a, b, sign)));
    }
}

/// A ball of `2 n²` triangles in a room of twelve.
pub fn ball(n: usize) -> Scene {
    let point = |i: usize, j: usize| {
        let theta = std::f64::consts::PI * i as f64 / n as f64;
        let phi = std::f64::consts::TAU * (j % n) as f64 / n as f64;
        let (x, z) = (theta.sin() * phi.cos(), theta.sin() * phi.sin());
        Vec3A::new(x as f32, theta.cos() as f32, z as f32)
    };
    let mut mesh = Mesh::new();
    for i in 0..n {
        for j in 0..n {
            quad(
                &mut mesh,
                [
                    point(i, j),
                    point(i, j + 1),
                    point(i + 1, j + 1),
                    point(i + 1, j),
                ],
            );
        }
    }
    cuboid(&mut mesh, Vec3A::ZERO, Vec3A::splat(2.5), 0.0);
    Scene {
        name: format!("ball, {} triangles", mesh.len()),
        mesh,
        eye: Vec3A::new(0.4, 0.7, 2.4),
        aim: Vec3A::ZERO,
        tangent: 0.5,
        light: (Vec3A::new(0.5, 2.4, 0.6), 0.3),
    }
}

/// Five walls, two boxes, a lamp: 36 triangles.
pub fn cornell() -> Scene {
    let mut mesh = Mesh::new();
    cuboid(&mut mesh, Vec3A::ZERO, Vec3A::ONE, 0.0);
    // without the wall on the side of the eye, which is the last
    mesh.truncate(10);
    cuboid(
        &mut mesh,
        Vec3A::new(-0.35, -0.4, -0.3),
        Vec3A::new(0.3, 0.6, 0.3),
        0.3,
    );
    cuboid(
        &mut mesh,
        Vec3A::new(0.35, -0.7, 0.35),
        Vec3A::splat(0.3),
        -0.3,
    );
    let lamp = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
    quad(
        &mut mesh,
        lamp.map(|(x, z)| Vec3A::new(0.25 * x, 0.99, 0.25 * z)),
    );
    Scene {
        name: format!("cornell, {} triangles", mesh.len()),
        mesh,
        eye: Vec3A::new(0.0, 0.0, 3.9),
        aim: Vec3A::ZERO,
        tangent: 0.34,
        light: (Vec3A::new(0.0, 0.98, 0.0), 0.25),
    }
}
