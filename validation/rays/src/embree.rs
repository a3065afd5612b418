//! Embree 4, opened while the program runs; the few functions and layouts of its interface that are needed.

use std::ffi::{CString, c_char, c_int, c_void};
use std::sync::atomic::{AtomicIsize, Ordering};

use glam::Vec3A;
use render::geometry::ray::Ray;

use crate::mesh::Mesh;

unsafe extern "C" {
    fn dlopen(name: *const c_char, flags: c_int) -> *mut c_void;
    fn dlsym(library: *mut c_void, name: *const c_char) -> *mut c_void;
}

type Pointer = *mut c_void;

/// RTCRayHit, with room for what other builds of the library append.
#[repr(C, align(64))]
struct RayHit {
    origin: [f32; 3],
    near: f32,
    direction: [f32; 3],
    time: f32,
    far: f32,
    mask: u32,
    id: u32,
    flags: u32,
    normal: [f32; 3],
    uv: [f32; 2],
    primitive: u32,
    geometry: u32,
    instance: [u32; 13],
}

impl RayHit {
    #[inline]
    fn new(ray: &Ray) -> Self {
        Self {
            origin: ray.origin.to_array(),
            near: 0.0,
            direction: ray.direction.to_array(),
            time: 0.0,
            far: ray.t_max,
            mask: u32::MAX,
            id: 0,
            flags: 0,
            normal: [0.0; 3],
            uv: [0.0; 2],
            primitive: u32::MAX,
            geometry: u32::MAX,
            instance: [u32::MAX; 13],
        }
    }
}

const ROBUST: c_int = 1 << 2;
const TRIANGLES: c_int = 0;
const INDICES: c_int = 0;
const VERTICES: c_int = 1;
const THREE_FLOATS: c_int = 0x9003;
const THREE_INTEGERS: c_int = 0x5003;

static BYTES: AtomicIsize = AtomicIsize::new(0);

unsafe extern "C" fn count(_: Pointer, bytes: isize, _: bool) -> bool {
    BYTES.fetch_add(bytes, Ordering::Relaxed);
    true
}

/// A library that has been opened.
pub struct Library(Pointer);

impl Library {
    pub fn open(path: &str) -> Result<Self, String> {
        let name = CString::new(path).map_err(|e| e.to_string())?;
        // 2: all symbols now
        let library = unsafe { dlopen(name.as_ptr(), 2) };
        if library.is_null() {
            return Err(format!("{path}: cannot be opened, expected Embree 4"));
        }
        Ok(Self(library))
    }

    /// The function of that name. The caller says its type.
    unsafe fn get<F: Copy>(&self, name: &str) -> F {
        let symbol = CString::new(name).expect("names have no zero bytes");
        let found = unsafe { dlsym(self.0, symbol.as_ptr()) };
        assert!(
            !found.is_null(),
            "no {name} in this library, expected Embree 4"
        );
        assert_eq!(size_of::<F>(), size_of::<Pointer>());
        unsafe { std::mem::transmute_copy(&found) }
    }
}

/// A mesh in Embree.
pub struct Embree {
    scene: Pointer,
    intersect: unsafe extern "C" fn(Pointer, *mut RayHit, Pointer),
    occluded: unsafe extern "C" fn(Pointer, *mut RayHit, Pointer),
    /// What the library holds for it, without the vertices and indices given to it.
    pub bytes: isize,
}

impl Embree {
    pub fn build(library: &Library, mesh: &Mesh, robust: bool) -> Self {
        let (vertices, indices) = shared(mesh);
        unsafe {
            let device = library
                .get::<unsafe extern "C" fn(*const c_char) -> Pointer>("rtcNewDevice")(
                c"threads=2".as_ptr(),
            );
            assert!(!device.is_null(), "Embree has no device");
            type Monitor = unsafe extern "C" fn(Pointer, isize, bool) -> bool;
            library.get::<unsafe extern "C" fn(Pointer, Monitor, Pointer)>(
                "rtcSetDeviceMemoryMonitorFunction",
            )(device, count, std::ptr::null_mut());
            let before = BYTES.load(Ordering::Relaxed);
            let scene =
                library.get::<unsafe extern "C" fn(Pointer) -> Pointer>("rtcNewScene")(device);
            let flags = if robust { ROBUST } else { 0 };
            library.get::<unsafe extern "C" fn(Pointer, c_int)>("rtcSetSceneFlags")(scene, flags);
            let geometry = library
                .get::<unsafe extern "C" fn(Pointer, c_int) -> Pointer>("rtcNewGeometry")(
                device, TRIANGLES,
            );
            type Buffer = unsafe extern "C" fn(Pointer, c_int, u32, c_int, usize, usize) -> Pointer;
            let buffer: Buffer = library.get("rtcSetNewGeometryBuffer");
            let to = buffer(geometry, VERTICES, 0, THREE_FLOATS, 12, vertices.len());
            std::ptr::copy_nonoverlapping(vertices.as_ptr(), to.cast(), vertices.len());
            let to = buffer(geometry, INDICES, 0, THREE_INTEGERS, 12, indices.len());
            std::ptr::copy_nonoverlapping(indices.as_ptr(), to.cast(), indices.len());
            library.get::<unsafe extern "C" fn(Pointer)>("rtcCommitGeometry")(geometry);
            library.get::<unsafe extern "C" fn(Pointer, Pointer) -> u32>("rtcAttachGeometry")(
                scene, geometry,
            );
            library.get::<unsafe extern "C" fn(Pointer)>("rtcCommitScene")(scene);
            let given = (vertices.len() + indices.len()) * 12;
            Self {
                scene,
                intersect: library.get("rtcIntersect1"),
                occluded: library.get("rtcOccluded1"),
                bytes: BYTES.load(Ordering::Relaxed) - before - given as isize,
            }
        }
    }

    #[inline]
    pub fn nearest(&self, ray: &Ray) -> f32 {
        let mut query = RayHit::new(ray);
        unsafe { (self.intersect)(self.scene, &mut query, std::ptr::null_mut()) };
        if query.geometry == u32::MAX {
            f32::INFINITY
        } else {
            query.far
        }
    }

    #[inline]
    pub fn any(&self, ray: &Ray) -> bool {
        let mut query = RayHit::new(ray);
        unsafe { (self.occluded)(self.scene, &mut query, std::ptr::null_mut()) };
        query.far == f32::NEG_INFINITY
    }
}

/// Vertices that neighbours share, and three of them a triangle.
fn shared(mesh: &Mesh) -> (Vec<[f32; 3]>, Vec<[u32; 3]>) {
    let mut known = std::collections::HashMap::new();
    let mut vertices = Vec::new();
    let mut index = |p: Vec3A| {
        let p = p.to_array();
        *known.entry(p.map(f32::to_bits)).or_insert_with(|| {
            vertices.push(p);
            vertices.len() as u32 - 1
        })
    };
    let indices = mesh.iter().map(|corners| corners.map(&mut index)).collect();
    (vertices, indices)
}
