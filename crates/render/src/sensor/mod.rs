//! Sensors: what a camera sample sees.

pub mod irradiancemeter;
pub mod perspective;

use crate::path::Start;
use crate::path::witness::View;
use irradiancemeter::IrradianceMeter;
use perspective::Perspective;

/// Any sensor.
#[derive(Clone, Debug)]
pub enum Camera {
    /// A pinhole.
    Perspective(Perspective),
    /// A bare plane.
    IrradianceMeter(Box<IrradianceMeter>),
}

impl Camera {
    /// Where the path of a film position in pixels begins; (0, 0) is the top left corner.
    #[inline]
    pub fn start(&self, x: f32, y: f32) -> Start<'_> {
        match self {
            Self::Perspective(camera) => {
                let (ray, axis) = camera.ray(x, y);
                Start::Ray { ray, axis }
            }
            Self::IrradianceMeter(plane) => plane.start(x, y),
        }
    }

    /// The view of a pixel of the film, from its middle.
    pub fn view(&self, column: u32, row: u32) -> View {
        match self {
            Self::Perspective(camera) => camera.view(column, row),
            Self::IrradianceMeter(plane) => plane.view(),
        }
    }

    /// The name of its plugin, and what its pixels record.
    pub fn describe(&self) -> &'static str {
        match self {
            Self::Perspective(_) => "perspective: radiance, W/(m^2 sr)",
            Self::IrradianceMeter(_) => "irradiancemeter: irradiance, W/m^2",
        }
    }

    /// The frame of its Stokes vectors in words.
    pub fn frame(&self) -> &'static str {
        match self {
            Self::Perspective(_) => {
                "per sample: x = normalize(viewing direction x camera up), image right; y image up; seen from the sensor"
            }
            Self::IrradianceMeter(_) => {
                "per ray: x = the plane's local x projected across the light, image right; y image up; seen from behind the plane"
            }
        }
    }
}
