use std::io::Cursor;

use exr::prelude::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer, LayerAttributes, ReadChannels,
    ReadLayers, Vec2, WritableImage, read,
};

use super::read::{Decoded, share};
use crate::height_map::Texels;

/// Decodes the first layer of an OpenEXR image that has red, green and blue, or one channel whatever its
/// name.
pub(super) fn decode(bytes: &[u8]) -> Result<Decoded, String> {
    let image = read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .all_layers()
        .all_attributes()
        .from_buffered(Cursor::new(bytes))
        .map_err(|error| format!("{error}: export the image again"))?;
    let mut seen = Vec::new();
    for layer in &image.layer_data {
        let channels = &layer.channel_data.list;
        if channels.iter().any(|c| c.sampling != Vec2(1, 1)) {
            seen.push("channels of lower resolution".to_owned());
            continue;
        }
        let named = |name: &str| {
            let found = channels.iter().find(|c| c.name.eq_case_insensitive(name));
            found.map(|channel| &channel.sample_data)
        };
        let alpha = named("A").map(|a| a.values_as_f32().collect::<Vec<f32>>());
        let transparent = alpha.map_or(0.0, |alpha| share(alpha.iter().map(|&a| a < 1.0)));
        let size = [layer.size.0, layer.size.1].map(|n| u32::try_from(n).unwrap_or(u32::MAX));
        if let (Some(r), Some(g), Some(b)) = (named("R"), named("G"), named("B")) {
            let rgb = (r.values_as_f32().zip(g.values_as_f32())).zip(b.values_as_f32());
            let texels = rgb.map(|((r, g), b)| [r, g, b]).collect();
            return Ok((size, Texels::RgbF32(texels), transparent));
        }
        let rest: Vec<_> = (channels.iter())
            .filter(|c| !c.name.eq_case_insensitive("A"))
            .collect();
        if let [only] = rest[..] {
            let texels = only.sample_data.values_as_f32().collect();
            return Ok((size, Texels::GreyF32(texels), transparent));
        }
        seen.extend(channels.iter().map(|c| c.name.to_string()));
    }
    Err(format!(
        "it has no red, green and blue and more than one channel ({}): export the one that is meant",
        seen.join(", ")
    ))
}

/// Encodes red, green and blue as an OpenEXR image of 32-bit floats, without loss.
pub(super) fn encode(size: [u32; 2], rgb: [Vec<f32>; 3]) -> Result<Vec<u8>, String> {
    let channels = rgb.into_iter().zip(["R", "G", "B"]);
    let channels = channels.map(|(samples, name)| AnyChannel::new(name, FlatSamples::F32(samples)));
    let layer = Layer::new(
        (size[0] as usize, size[1] as usize),
        LayerAttributes::default(),
        Encoding::SMALL_LOSSLESS,
        AnyChannels::sort(channels.collect()),
    );
    let mut bytes = Cursor::new(Vec::new());
    let image = Image::from_layer(layer);
    (image.write().to_buffered(&mut bytes)).map_err(|error| error.to_string())?;
    Ok(bytes.into_inner())
}
