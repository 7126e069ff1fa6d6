use std::io::Cursor;
use std::path::Path;

use glam::{Vec2, Vec3};
use image::{ImageBuffer, ImageFormat, Luma, Rgb, RgbImage};

use super::exr_file;
use crate::cli::failure::Failure;
use crate::height_map::HeightMap;

/// A height map for a file of that name: OpenEXR, or else PNG of 16 bits.
pub(super) fn heights(map: &HeightMap, path: &Path) -> Result<Vec<u8>, Failure> {
    if is_exr(path) {
        // In three channels, as engines and the `image` crate read nothing less.
        return exr([0; 3].map(|_| map.heights().to_vec()), map.size(), path);
    }
    let low = map.heights().iter().copied().fold(f32::INFINITY, f32::min);
    let high = map
        .heights()
        .iter()
        .copied()
        .fold(f32::NEG_INFINITY, f32::max);
    if low < 0.0 || high > 1.0 {
        return Err(Failure::Error(format!(
            "{}: a PNG holds heights from 0 to 1, and these go from {low} to {high}: write an .exr, or \
             stretch them (--stretch)",
            path.display()
        )));
    }
    let steps = |&h: &f32| (f64::from(h) * 65_535.0).round() as u16;
    let texels: Vec<u16> = map.heights().iter().map(steps).collect();
    png::<Luma<u16>>(map.size(), texels, path)
}

/// A normal map: OpenEXR from −1 to 1, or else PNG of 8 bits, 128 being 0.
pub(super) fn normals(normals: &[Vec3], size: [u32; 2], path: &Path) -> Result<Vec<u8>, Failure> {
    if is_exr(path) {
        let channel = |i: usize| normals.iter().map(|n| n[i]).collect();
        return exr([0, 1, 2].map(channel), size, path);
    }
    let texels = normals
        .iter()
        .flat_map(|&n| crate::height_map::encode_normal(n));
    png::<Rgb<u8>>(size, texels.collect(), path)
}

/// A derivative map: `F_u`, `F_v` and the height.
pub(super) fn derivatives(
    slopes: &[Vec2],
    map: &HeightMap,
    path: &Path,
) -> Result<Vec<u8>, Failure> {
    let channel = |i: usize| slopes.iter().map(|s| s[i]).collect();
    exr(
        [channel(0), channel(1), map.heights().to_vec()],
        map.size(),
        path,
    )
}

/// A picture for people.
pub(super) fn picture(image: RgbImage, path: &Path) -> Result<Vec<u8>, Failure> {
    let size = [image.width(), image.height()];
    png::<Rgb<u8>>(size, image.into_raw(), path)
}

fn is_exr(path: &Path) -> bool {
    path.extension()
        .is_some_and(|e| e.eq_ignore_ascii_case("exr"))
}

fn exr(rgb: [Vec<f32>; 3], size: [u32; 2], path: &Path) -> Result<Vec<u8>, Failure> {
    exr_file::encode(size, rgb).map_err(|reason| not_encoded(path, &reason))
}

fn png<P>(size: [u32; 2], texels: Vec<P::Subpixel>, path: &Path) -> Result<Vec<u8>, Failure>
where
    P: image::PixelWithColorType,
    [P::Subpixel]: image::EncodableLayout,
{
    let mut bytes = Cursor::new(Vec::new());
    ImageBuffer::<P, _>::from_raw(size[0], size[1], texels)
        .ok_or_else(|| not_encoded(path, "it has the wrong size"))?
        .write_to(&mut bytes, ImageFormat::Png)
        .map_err(|error| not_encoded(path, &error.to_string()))?;
    Ok(bytes.into_inner())
}

fn not_encoded(path: &Path, reason: &str) -> Failure {
    Failure::Error(format!("cannot make {}: {reason}", path.display()))
}
