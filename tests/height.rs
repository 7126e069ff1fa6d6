//! `fresco height`, run in this process on files that the tests make.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on panics")]

use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use bevy_fresco::cli::run;
use exr::prelude::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer, LayerAttributes, WritableImage,
};
use image::{GrayImage, ImageBuffer, Luma, Rgb, RgbImage, Rgba, RgbaImage};
use tempfile::TempDir;

struct Ran {
    code: u8,
    out: String,
    err: String,
}

fn code(exit: ExitCode) -> u8 {
    (0..=255).find(|&c| ExitCode::from(c) == exit).unwrap()
}

/// A folder to work in.
struct Folder(TempDir);

impl Folder {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// `fresco height`, with the folder for `@` in arguments.
    fn height(&self, args: &[&str]) -> Ran {
        let folder = self.0.path().to_str().unwrap();
        let args = args
            .iter()
            .map(|a| a.replace('@', &format!("{folder}/")).into());
        let all: Vec<OsString> = ["fresco".into(), "height".into()]
            .into_iter()
            .chain(args)
            .collect();
        let (mut out, mut err) = (Vec::new(), Vec::new());
        let exit = run(all, &mut out, &mut err);
        Ran {
            code: code(exit),
            out: String::from_utf8(out).unwrap(),
            err: String::from_utf8(err).unwrap(),
        }
    }

    fn made(&self, args: &[&str]) -> String {
        let ran = self.height(args);
        assert_eq!((ran.code, ran.err.as_str()), (0, ""), "{args:?}");
        ran.out
    }

    /// Exit code 1, one line that has all of `parts`, nothing on standard output, nothing written.
    fn refuses(&self, args: &[&str], parts: &[&str]) {
        let before = self.names();
        let ran = self.height(args);
        assert_eq!(
            (ran.code, ran.out.as_str()),
            (1, ""),
            "{args:?}: {}",
            ran.err
        );
        assert_eq!(ran.err.lines().count(), 1, "{}", ran.err);
        for part in parts {
            assert!(ran.err.contains(part), "{part} is not in: {}", ran.err);
        }
        assert_eq!(self.names(), before, "{args:?}");
    }

    fn names(&self) -> Vec<String> {
        let entries = fs::read_dir(self.0.path()).unwrap();
        let mut names: Vec<_> = entries
            .map(|e| e.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }

    /// A photo of 96 × 64 texels with some relief in it.
    fn photo(&self, name: &str) {
        let photo = RgbImage::from_fn(96, 64, |x, y| {
            let (x, y) = (x as f32, y as f32);
            let light = 110.0 + 50.0 * (x / 6.0).sin() * (y / 5.0).cos() + 0.3 * x;
            Rgb([light, 0.8 * light, 0.7 * light].map(|c| c as u8))
        });
        photo.save(self.path(name)).unwrap();
    }

    fn ramp8(&self, name: &str) {
        let ramp = GrayImage::from_fn(256, 4, |x, _| Luma([x as u8]));
        ramp.save(self.path(name)).unwrap();
    }

    fn exr(&self, name: &str, size: (usize, usize), channels: &[(&str, Vec<f32>)]) {
        write_exr(&self.path(name), size, channels);
    }
}

fn write_exr(path: &Path, size: (usize, usize), channels: &[(&str, Vec<f32>)]) {
    let channels = (channels.iter())
        .map(|(name, samples)| AnyChannel::new(*name, FlatSamples::F32(samples.clone())));
    let channels = AnyChannels::sort(channels.collect());
    let layer = Layer::new(
        size,
        LayerAttributes::default(),
        Encoding::default(),
        channels,
    );
    Image::from_layer(layer).write().to_file(path).unwrap();
}

/// The channels of an OpenEXR image, in the order of their names.
fn read_exr(path: &Path) -> Vec<(String, Vec<f32>)> {
    let image = exr::prelude::read_first_flat_layer_from_file(path).unwrap();
    let channels = &image.layer_data.channel_data.list;
    let samples = |c: &AnyChannel<FlatSamples>| c.sample_data.values_as_f32().collect();
    channels
        .iter()
        .map(|c| (c.name.to_string(), samples(c)))
        .collect()
}

fn read16(path: &Path) -> ImageBuffer<Luma<u16>, Vec<u16>> {
    match image::open(path).unwrap() {
        image::DynamicImage::ImageLuma16(image) => image,
        other => panic!("{:?}", other.color()),
    }
}

fn srgb_decoded(c: f64) -> f64 {
    if c <= 0.040_45 {
        c / 12.92
    } else {
        ((c + 0.055) / 1.055).powf(2.4)
    }
}

#[test]
fn a_photo_becomes_all_maps() {
    let folder = Folder::new();
    folder.photo("wall.png");
    let out = folder.made(&[
        "@wall.png",
        "--normal-map",
        "@n.png",
        "--derivative-map",
        "@d.exr",
        "--preview",
        "@p.png",
    ]);
    for part in [
        "96 × 64 texels, 8 bits, colour, read as sRGB",
        "heights from 0 to 1, stretched",
        "warnings",
        "--dequantize",
        "wall.height.png",
        "d.exr",
    ] {
        assert!(out.contains(part), "no {part} in {out}");
    }
    let expected = ["d.exr", "n.png", "p.png", "wall.height.png", "wall.png"];
    assert_eq!(folder.names(), expected);

    let map = read16(&folder.path("wall.height.png"));
    assert_eq!(map.dimensions(), (96, 64));
    let ends = map.pixels().map(|p| p.0[0]);
    assert_eq!((ends.clone().min(), ends.max()), (Some(0), Some(u16::MAX)));
    let normals = image::open(folder.path("n.png")).unwrap().to_rgb8();
    assert!(
        normals.pixels().all(|p| p.0[2] > 127),
        "normals point outwards"
    );
    // Photo, heights, relief.
    let preview = image::open(folder.path("p.png")).unwrap();
    assert_eq!((preview.width(), preview.height()), (3 * 96 + 2 * 8, 64));

    // Slopes and normals are those of the heights that were written.
    let channels = read_exr(&folder.path("d.exr"));
    let names: Vec<&str> = channels.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(names, ["B", "G", "R"]);
    let [heights, by_v, by_u] = [0, 1, 2].map(|i| &channels[i].1);
    let middle = 30 * 96 + 50;
    let difference = 0.5 * 96.0 * (heights[middle + 1] - heights[middle - 1]);
    assert!((by_u[middle] - difference).abs() < 0.25 * difference.abs() + 0.2);
    let normal = normals
        .get_pixel(50, 30)
        .0
        .map(|c| f32::from(c) / 127.5 - 1.0);
    // Texels are square: by_v is by the height of the image, which is 64/96 of its width.
    let slopes = [0.03 * by_u[middle], 0.03 * by_v[middle] * 96.0 / 64.0];
    assert!(
        (normal[0] / normal[2] + slopes[0]).abs() < 0.03,
        "{normal:?}"
    );
    assert!(
        (normal[1] / normal[2] - slopes[1]).abs() < 0.03,
        "{normal:?}"
    );
}

/// Bump test 16: heights are taken as they are, light is decoded as it was encoded.
#[test]
fn numbers_are_read_as_what_they_are() {
    let folder = Folder::new();
    folder.ramp8("ramp.png");
    let heights = |args: &[&str]| {
        folder.made(&[&["@ramp.png", "-q", "-o", "@out.png"], args].concat());
        let map = read16(&folder.path("out.png"));
        let row: Vec<f64> = (0..256)
            .map(|x| f64::from(map.get_pixel(x, 1).0[0]) / 65_535.0)
            .collect();
        row
    };
    let ramp: Vec<f64> = (0..256).map(|i| f64::from(i) / 255.0).collect();
    let light: Vec<f64> = ramp.iter().map(|&c| srgb_decoded(c)).collect();
    let close = |a: &[f64], b: &[f64]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-4);
    assert!(close(&heights(&["--data"]), &ramp));
    assert!(close(&heights(&["--linear"]), &ramp));
    assert!(close(&heights(&["--srgb"]), &light));
    assert!(close(&heights(&[]), &light), "8-bit photos are sRGB");

    // 16 bits of one channel and floating point are linear; 16 bits of three are photos again.
    let fine = |x: u32| (x * 257) as u16 ^ 1;
    ImageBuffer::from_fn(256, 4, |x, _| Luma([fine(x)]))
        .save(folder.path("ramp.png"))
        .unwrap();
    assert!(close(&heights(&[]), &ramp));
    ImageBuffer::from_fn(256, 4, |x, _| Rgb([fine(x); 3]))
        .save(folder.path("ramp.png"))
        .unwrap();
    assert!(close(&heights(&[]), &light));
    let float = (0..4 * 256).map(|i| (i % 256) as f32 / 255.0).collect();
    folder.exr("ramp.png", (256, 4), &[("Y", float)]);
    assert!(close(&heights(&[]), &ramp), "files are told by content");
}

#[test]
fn reads_what_cameras_and_programs_write() {
    let folder = Folder::new();
    folder.photo("a.png");
    let photo = image::open(folder.path("a.png")).unwrap().to_rgb8();
    photo.save(folder.path("a.jpg")).unwrap();
    let half = |p: &Rgb<u8>| Rgba([p.0[0], p.0[1], p.0[2], 128]);
    RgbaImage::from_fn(96, 64, |x, y| half(photo.get_pixel(x, y)))
        .save(folder.path("rgba.png"))
        .unwrap();
    let float = |i: usize| {
        photo
            .pixels()
            .map(|p| f32::from(p.0[i]) / 100.0)
            .collect::<Vec<_>>()
    };
    let rgb = [("R", float(0)), ("G", float(1)), ("B", float(2))];
    folder.exr("a.exr", (96, 64), &rgb);
    let rgb32 = image::DynamicImage::ImageRgb8(photo).to_rgb32f();
    rgb32.save(folder.path("a.hdr")).unwrap();
    for (name, told) in [
        ("a.jpg", "8 bits, colour, read as sRGB"),
        ("rgba.png", "100.00 % of the image are transparent"),
        ("a.exr", "floating point, colour, read as linear"),
        ("a.hdr", "floating point, colour, read as linear"),
    ] {
        let out = folder.made(&[&format!("@{name}"), "-o", "@out.exr"]);
        assert!(out.contains(told), "{name}: {out}");
        let heights = read_exr(&folder.path("out.exr"));
        assert_eq!(heights.len(), 3, "red, green and blue, all the same");
        assert!(heights.windows(2).all(|w| w[0].1 == w[1].1));
        let ends = heights[0]
            .1
            .iter()
            .fold([1.0_f32, 0.0_f32], |[l, h], &v| [l.min(v), h.max(v)]);
        assert_eq!(ends, [0.0, 1.0], "{name}");
    }
}

/// What was written is read again as it was: nothing drifts on the way round.
#[test]
fn maps_go_round() {
    let folder = Folder::new();
    folder.photo("a.png");
    folder.made(&["@a.png", "--dequantize", "-o", "@one.exr"]);
    folder.made(&["@one.exr", "--data", "-o", "@two.exr"]);
    assert_eq!(
        read_exr(&folder.path("one.exr")),
        read_exr(&folder.path("two.exr"))
    );
    folder.made(&["@one.exr", "--data", "-o", "@three.png"]);
    folder.made(&["@three.png", "--data", "-o", "@four.png"]);
    let [three, four] = ["three.png", "four.png"].map(|n| fs::read(folder.path(n)).unwrap());
    assert_eq!(three, four);
    let exact = &read_exr(&folder.path("one.exr"))[0].1;
    for (a, b) in read16(&folder.path("three.png")).pixels().zip(exact) {
        assert!((f32::from(a.0[0]) / 65_535.0 - b).abs() < 1e-5);
    }
}

#[test]
fn options_do_what_they_say() {
    let folder = Folder::new();
    folder.photo("a.png");
    let heights = |args: &[&str]| -> Vec<f32> {
        folder.made(&[&["@a.png", "-q", "-o", "@o.exr"], args].concat());
        read_exr(&folder.path("o.exr")).remove(0).1
    };
    let plain = heights(&[]);
    let inverted = heights(&["--invert"]);
    assert!(
        plain
            .iter()
            .zip(&inverted)
            .all(|(a, b)| (a + b - 1.0).abs() < 1e-5)
    );
    let cut = heights(&["--percentile", "10"]);
    assert!(cut.iter().filter(|&&h| h == 1.0).count() > 500);
    let tilt = |h: &[f32]| {
        let at = |x: usize| (0..64).map(|y| h[y * 96 + x]).sum::<f32>() / 64.0;
        (0..30).map(|x| at(66 + x) - at(x)).sum::<f32>() / 30.0
    };
    assert!(tilt(&heights(&["--flatten", "20"])).abs() < 0.3 * tilt(&plain).abs());
    let rough = |h: &[f32]| h.windows(2).map(|w| (w[1] - w[0]).powi(2)).sum::<f32>();
    assert!(rough(&heights(&["--smooth", "2"])) < rough(&plain));
    assert!(heights(&["--dequantize"]) != plain);
    for tile in [&["--tile"][..], &["--tile=u"], &["--tile=both"]] {
        let out = folder.made(&[&["@a.png", "-o", "@o.exr"], tile].concat());
        assert!(out.contains("does not tile"), "{out}");
    }
    let [up, down] = ["up", "down"].map(|green| {
        let args = ["@a.png", "-q", "--normal-map", "@n.exr", "--green", green];
        folder.made(&args);
        read_exr(&folder.path("n.exr")).swap_remove(1).1
    });
    assert!(up.iter().zip(&down).all(|(a, b)| *a == -*b));
    let heights = |kernel| {
        folder.made(&[
            "@a.png",
            "-q",
            "--derivative-map",
            "@d.exr",
            "--kernel",
            kernel,
        ]);
        read_exr(&folder.path("d.exr"))
    };
    assert!(heights("bilinear") != heights("catmull-rom"));
}

#[test]
fn gloss_is_told_and_marked() {
    let folder = Folder::new();
    let photo = RgbImage::from_fn(160, 120, |x, y| {
        let (dx, dy) = (x as f32 - 100.0, y as f32 - 50.0);
        let gloss = 190.0 * (-(dx * dx + dy * dy) / 150.0).exp();
        let clay = 1.0 + 0.05 * (x as f32 / 5.0).sin();
        Rgb([90.0, 60.0, 50.0].map(|c| (c * clay + gloss).min(255.0) as u8))
    });
    photo.save(folder.path("g.png")).unwrap();
    let out = folder.made(&["@g.png", "--preview", "@p.png"]);
    assert!(
        out.contains("gloss:") && out.contains("polarisers"),
        "{out}"
    );
    let preview = image::open(folder.path("p.png")).unwrap().to_rgb8();
    assert_eq!(preview.get_pixel(100, 50).0, [255, 0, 255]);
    assert_ne!(preview.get_pixel(10, 10).0, [255, 0, 255]);
}

#[test]
fn says_what_is_wrong_with_files() {
    let folder = Folder::new();
    folder.refuses(&["@none.png"], &["cannot read", "none.png"]);
    fs::write(folder.path("text.png"), "no image at all").unwrap();
    folder.refuses(&["@text.png"], &["text.png", "must be a PNG", "convert"]);
    fs::write(folder.path("empty.png"), "").unwrap();
    folder.refuses(&["@empty.png"], &["empty.png", "is empty"]);
    folder.refuses(&["@"], &["cannot read"]);
    fs::write(folder.path("a.gif"), b"GIF89a\x01\0\x01\0").unwrap();
    folder.refuses(&["@a.gif"], &["a.gif", "Gif", "convert"]);
    folder.photo("whole.png");
    let bytes = fs::read(folder.path("whole.png")).unwrap();
    fs::write(folder.path("cut.png"), &bytes[..bytes.len() / 2]).unwrap();
    folder.refuses(&["@cut.png"], &["cut.png", "export the image again"]);

    let ones = |n: usize| vec![1.0; n];
    let mut bad = ones(12);
    bad[5] = f32::NAN;
    folder.exr("nan.exr", (4, 3), &[("Y", bad.clone())]);
    folder.refuses(
        &["@nan.exr"],
        &["nan.exr", "texel (1, 1)", "no finite number"],
    );
    folder.refuses(&["@nan.exr", "--data"], &["texel (1, 1)"]);
    bad[5] = f32::INFINITY;
    folder.exr(
        "inf.exr",
        (4, 3),
        &[("R", bad), ("G", ones(12)), ("B", ones(12))],
    );
    folder.refuses(&["@inf.exr"], &["inf.exr", "texel (1, 1)"]);
    folder.exr("uv.exr", (4, 3), &[("U", ones(12)), ("V", ones(12))]);
    folder.refuses(&["@uv.exr"], &["uv.exr", "U, V", "export the one"]);
    let cut = fs::read(folder.path("uv.exr")).unwrap();
    fs::write(folder.path("cut.exr"), &cut[..cut.len() - 20]).unwrap();
    folder.refuses(&["@cut.exr"], &["cut.exr"]);
}

#[test]
fn heights_have_one_channel_and_fit_their_file() {
    let folder = Folder::new();
    folder.photo("photo.png");
    folder.refuses(
        &["@photo.png", "--data"],
        &["photo.png", "has a colour", "as a photo"],
    );
    let heights = (0..12).map(|i| i as f32 - 3.0).collect();
    folder.exr("deep.exr", (4, 3), &[("Z", heights)]);
    folder.refuses(
        &["@deep.exr", "--data", "-o", "@o.png"],
        &["o.png", "from -3 to 8", ".exr", "--stretch"],
    );
    folder.made(&["@deep.exr", "--data", "-o", "@o.exr"]);
    assert_eq!(read_exr(&folder.path("o.exr"))[0].1[11], 8.0);
    folder.made(&["@deep.exr", "--data", "--stretch", "-o", "@o.png"]);
    assert_eq!(read16(&folder.path("o.png")).get_pixel(3, 2).0[0], u16::MAX);
}

#[test]
fn says_what_is_wrong_with_names() {
    let folder = Folder::new();
    folder.photo("a.png");
    folder.refuses(&["@a.png", "-o", "@a.tif"], &["a.tif", ".png or .exr"]);
    folder.refuses(
        &["@a.png", "-o", "@noextension"],
        &["noextension", ".png or .exr"],
    );
    folder.refuses(
        &["@a.png", "--normal-map", "@n.jpg"],
        &["n.jpg", ".png or .exr"],
    );
    folder.refuses(
        &["@a.png", "--derivative-map", "@d.png"],
        &["d.png", ".exr"],
    );
    folder.refuses(&["@a.png", "--preview", "@p.exr"], &["p.exr", ".png"]);
    folder.refuses(&["@a.png", "-o", "@no/where.png"], &["no", "create it"]);
    folder.refuses(
        &["@a.png", "-o", "@b.png", "--preview", "@./b.png"],
        &["different names"],
    );
    let before = fs::read(folder.path("a.png")).unwrap();
    folder.refuses(&["@a.png", "-o", "@./a.png"], &["overwritten", "-o"]);
    folder.refuses(
        &["@a.png", "--preview", "@a.png"],
        &["overwritten", "--preview"],
    );
    assert_eq!(fs::read(folder.path("a.png")).unwrap(), before);
}

#[test]
fn bad_options_are_usage_errors() {
    let folder = Folder::new();
    folder.photo("a.png");
    for options in [
        &["--percentile", "50"][..],
        &["--percentile", "0"],
        &["--flatten", "-1"],
        &["--smooth", "NaN"],
        &["--scale", "0"],
        &["--tile=w"],
        &["--green", "left"],
        &["--kernel", "sharp"],
        &["--data", "--srgb"],
        &["--srgb", "--linear"],
        &["--stretch"],
        &["--colour"],
    ] {
        let ran = folder.height(&[&["@a.png"], options].concat());
        assert_eq!((ran.code, ran.out.as_str()), (2, ""), "{options:?}");
        assert!(ran.err.contains("error:"), "{options:?}: {}", ran.err);
    }
    assert_eq!(folder.names(), ["a.png"]);
}

#[test]
fn help_lets_a_stranger_start() {
    let help = Folder::new().made(&["--help"]);
    for part in [
        "fresco height wall.jpg --preview wall.png",
        "8 bits and 16-bit colour are sRGB",
        "--derivative-map <EXR>",
        "docs/height_maps.md",
    ] {
        assert!(help.contains(part), "no {part} in {help}");
    }
}
