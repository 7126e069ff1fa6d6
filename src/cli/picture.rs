use std::io::Cursor;

use image::{ImageFormat, RgbImage};

use super::args::ResultArgs;
use super::failure::Failure;
use super::progress::Progress;
use super::scene::Loaded;
use crate::gltf::{GltfCamera, GltfProjection};
use crate::radiosity::{Bake, Camera, Picture, PreviewSettings, Projection, preview};
use glam::DVec3;

/// Draws a bake as the bytes of a PNG file.
pub(super) fn draw(
    loaded: &Loaded,
    origin: DVec3,
    bake: &Bake,
    args: &ResultArgs,
    progress: &Progress,
) -> Result<Vec<u8>, Failure> {
    let (width, height) = args.preview_size;
    let aspect = width as f32 / height as f32;
    let settings = PreviewSettings {
        width,
        height,
        camera: (loaded.camera.as_ref()).map(|camera| camera_of(camera, origin, aspect)),
        exposure: args.exposure,
    };
    png(preview(&loaded.scene, bake, &settings, progress)?)
}

/// The camera of the file. Where the picture is narrower than the camera was made for, it shows
/// more above and below instead of less at the sides.
fn camera_of(camera: &GltfCamera, origin: DVec3, aspect: f32) -> Camera {
    let projection = match camera.projection {
        GltfProjection::Perspective {
            yfov,
            aspect: Some(wanted),
            ..
        } if wanted > aspect => Projection::Perspective {
            vertical_angle: 2.0 * ((0.5 * yfov).tan() * wanted / aspect).atan(),
        },
        GltfProjection::Perspective { yfov, .. } => Projection::Perspective {
            vertical_angle: yfov,
        },
        GltfProjection::Orthographic { xmag, ymag, .. } => Projection::Orthographic {
            height: 2.0 * ymag.max(xmag / aspect),
        },
    };
    Camera {
        position: origin + camera.position.as_dvec3(),
        forward: camera.forward,
        up: camera.up,
        projection,
    }
}

fn png(picture: Picture) -> Result<Vec<u8>, Failure> {
    let Picture {
        width,
        height,
        pixels,
    } = picture;
    let mut bytes = Cursor::new(Vec::new());
    RgbImage::from_raw(width, height, pixels.into_flattened())
        .ok_or_else(|| "it has the wrong size".to_owned())
        .and_then(|image| {
            let written = image.write_to(&mut bytes, ImageFormat::Png);
            written.map_err(|error| error.to_string())
        })
        .map_err(|reason| Failure::Error(format!("cannot make the preview: {reason}")))?;
    Ok(bytes.into_inner())
}
