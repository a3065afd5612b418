//! From the statements of an OBJ file to one mesh with one index buffer.

use std::collections::HashMap;

use super::mesh::{Mesh, count_degenerate, vertex_normals};

/// No texture coordinate or normal at this corner.
pub(super) const NONE: u32 = u32::MAX;

/// What the file says, with indices as in the file but counted from zero.
#[derive(Default)]
pub(super) struct Statements {
    pub(super) positions: Vec<[f32; 3]>,
    pub(super) texcoords: Vec<[f32; 2]>,
    pub(super) normals: Vec<[f32; 3]>,
    /// Position, texture coordinate, normal.
    pub(super) corners: Vec<[u32; 3]>,
    /// End of the corners of each face, and its line.
    pub(super) faces: Vec<(usize, u32)>,
    pub(super) ignored: usize,
}

impl Statements {
    /// Merges equal corners into vertices; errors come with their line.
    pub(super) fn mesh(&self, flip_tex_coords: bool) -> Result<Mesh, (u32, String)> {
        let mut mesh = Mesh::default();
        let mut known: HashMap<[u32; 3], u32> = HashMap::with_capacity(self.positions.len());
        let mut corners: Vec<[u32; 3]> = Vec::with_capacity(self.positions.len());
        let mut start = 0;
        for &(end, line) in &self.faces {
            let mut fan = [0; 2];
            for (k, corner) in self.corners[start..end].iter().enumerate() {
                let vertex = match known.get(corner) {
                    Some(&vertex) => vertex,
                    None => {
                        self.check(corner).map_err(|message| (line, message))?;
                        let vertex = u32::try_from(corners.len())
                            .map_err(|_| (line, "more than 4294967295 vertices".to_owned()))?;
                        corners.push(*corner);
                        known.insert(*corner, vertex);
                        vertex
                    }
                };
                match k {
                    0 => fan[0] = vertex,
                    1 => fan[1] = vertex,
                    _ => {
                        mesh.triangles.push([fan[0], fan[1], vertex]);
                        fan[1] = vertex;
                    }
                }
            }
            start = end;
        }
        mesh.positions = corners
            .iter()
            .map(|c| self.positions[c[0] as usize])
            .collect();
        self.attributes(&mut mesh, &corners, flip_tex_coords);
        self.remark(&mut mesh);
        Ok(mesh)
    }

    fn check(&self, corner: &[u32; 3]) -> Result<(), String> {
        let lists = [
            (self.positions.len(), "vertex"),
            (self.texcoords.len(), "texture coordinate"),
            (self.normals.len(), "normal"),
        ];
        for (&index, (count, what)) in corner.iter().zip(lists) {
            if index != NONE && index as usize >= count {
                return Err(format!(
                    "face names {what} {}, expected at most {count}, the number in the file",
                    u64::from(index) + 1
                ));
            }
        }
        Ok(())
    }

    fn attributes(&self, mesh: &mut Mesh, corners: &[[u32; 3]], flip_tex_coords: bool) {
        let absent = |k: usize| corners.iter().filter(|c| c[k] == NONE).count();
        if absent(1) < corners.len() {
            let texcoord = |corner: &[u32; 3]| match self.texcoords.get(corner[1] as usize) {
                Some(&[u, v]) if flip_tex_coords => [u, 1.0 - v],
                Some(&uv) => uv,
                None => [0.0, 0.0],
            };
            mesh.texcoords = Some(corners.iter().map(texcoord).collect());
            if absent(1) > 0 {
                let n = absent(1);
                mesh.notices.push(format!(
                    "{n} vertices lack texture coordinates and get (0, 0)"
                ));
            }
        }
        if absent(2) < corners.len() {
            let given = |corner: &[u32; 3]| {
                let normal = glam::Vec3::from(*self.normals.get(corner[2] as usize)?).as_dvec3();
                Some(normal.try_normalize()?.as_vec3().to_array())
            };
            let mut normals: Vec<_> = corners.iter().map(given).collect();
            let missing = normals.iter().filter(|normal| normal.is_none()).count();
            if missing > 0 {
                for (normal, smooth) in normals.iter_mut().zip(vertex_normals(mesh)) {
                    normal.get_or_insert(smooth);
                }
                mesh.notices.push(format!(
                    "{missing} vertices lack a normal and get a smooth one"
                ));
            }
            mesh.normals = Some(normals.into_iter().flatten().collect());
        }
    }

    fn remark(&self, mesh: &mut Mesh) {
        mesh.degenerate = count_degenerate(mesh);
        if mesh.triangles.is_empty() {
            mesh.notices.push("the file has no faces".to_owned());
        }
        if mesh.degenerate > 0 {
            let n = mesh.degenerate;
            mesh.notices.push(format!("{n} triangles have no area"));
        }
        if self.ignored > 0 {
            let n = self.ignored;
            mesh.notices.push(format!(
                "{n} statements of points, lines or free-form surfaces are ignored"
            ));
        }
    }
}
