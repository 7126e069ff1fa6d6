//! The shader's formulas against their twins in Rust, on 10⁵ triangles: Bump test 3, and the rest of them.

use std::f32::consts::PI;

use bevy::math::DVec3;
use bevy::prelude::*;
use bevy::render::RenderApp;
use bevy::render::render_resource::{
    BufferDescriptor, BufferInitDescriptor, BufferUsages, CommandEncoderDescriptor,
    ComputePassDescriptor, MapMode, PipelineCompilationOptions, PollType,
    RawComputePipelineDescriptor, ShaderModuleDescriptor, ShaderSource,
};
use bevy::render::renderer::{RenderDevice, RenderQueue};
use bevy_fresco::bump::{
    MAX_SLOPE, Steps, bumped_normal, displaced_normal, roughened, uv_gradients,
};

use super::degrees;
use crate::stage::{Stage, on_stage};

/// `Case` in `formulas.wgsl`.
#[derive(Clone, Copy)]
struct Case {
    steps: Steps,
    height: f32,
    uv: [Vec2; 2],
    slopes: Vec2,
    roughness: f32,
    variance: f32,
    normal_changes: [Vec3; 2],
}

impl Case {
    fn bytes(&self) -> Vec<u8> {
        let [a, b] = self.steps.along;
        let [p, q] = self.uv;
        let [na, nb] = self.normal_changes;
        let rest = Vec4::new(self.slopes.x, self.slopes.y, self.roughness, self.variance);
        [
            a.extend(0.0),
            b.extend(0.0),
            self.steps.normal.extend(self.height),
            Vec4::new(p.x, p.y, q.x, q.y),
            rest,
            na.extend(0.0),
            nb.extend(0.0),
        ]
        .iter()
        .flat_map(|v| v.to_array())
        .flat_map(f32::to_le_bytes)
        .collect()
    }

    fn gradient(&self) -> Vec3 {
        let [by_u, by_v] = uv_gradients(self.steps, self.uv);
        self.slopes.x * by_u + self.slopes.y * by_v
    }

    /// The bumped normal in f64, where the triangle has area.
    fn truth(&self) -> Vec3 {
        let [a, b, n]: [DVec3; 3] =
            [self.steps.along[0], self.steps.along[1], self.steps.normal].map(Into::into);
        let change = |uv: Vec2| {
            f64::from(self.slopes.x) * f64::from(uv.x) + f64::from(self.slopes.y) * f64::from(uv.y)
        };
        let [p, q] = self.uv.map(change);
        let gradient = (p * b.cross(n) + q * n.cross(a)) / n.dot(a.cross(b));
        let steep = f64::from(MAX_SLOPE).min(gradient.length());
        (n - gradient.normalize_or_zero() * steep)
            .normalize()
            .as_vec3()
    }
}

/// Small and simple: the tests need no good random numbers, but the same ones each time.
struct Random(u32);

impl Random {
    fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
        let word = ((self.0 >> ((self.0 >> 28) + 4)) ^ self.0).wrapping_mul(277_803_737);
        ((word >> 22) ^ word) as f32 / u32::MAX as f32
    }

    fn signed(&mut self) -> f32 {
        2.0 * self.next() - 1.0
    }

    fn direction(&mut self) -> Vec3 {
        let z = self.signed();
        let (y, x) = (PI * self.signed()).sin_cos();
        Vec3::new(x, y, 0.0) * (1.0 - z * z).max(0.0).sqrt() + Vec3::Z * z
    }
}

/// Triangles with texture coordinates of less and less area down to exactly none, and some without area in
/// space.
fn cases(count: usize) -> Vec<Case> {
    let r = &mut Random(3);
    (0..count)
        .map(|i| {
            let [a, b] = [r.direction(), r.direction()];
            let normal = a.cross(b).try_normalize().unwrap_or(Vec3::Y);
            let squeezed = match i % 10 {
                0 => 0.0,
                k => 10_f32.powi(-(k as i32)),
            };
            // Collapsed in space as well, now and then.
            let b = if i % 1000 == 7 { a } else { b };
            let size = [1.0, 1e-9, 1e9][usize::from(i % 50 == 1) + 2 * usize::from(i % 50 == 2)];
            let first = Vec2::new(1.0, 0.3);
            Case {
                steps: Steps {
                    normal,
                    along: [a * size, b * size],
                },
                height: 0.1 * r.signed(),
                uv: [first, first + Vec2::new(-0.3, 1.0) * squeezed].map(|uv| uv * size),
                slopes: Vec2::new(r.signed(), r.signed()),
                roughness: r.next(),
                variance: r.next() * r.next(),
                normal_changes: [0.3 * size * r.direction(), 0.3 * size * r.direction()],
            }
        })
        .collect()
}

/// Runs the shader; gives the bumped normal with the roughness, and the displaced normal.
fn run(stage: &mut Stage, cases: &[Case]) -> Vec<[Vec4; 2]> {
    let world = stage.app().sub_app(RenderApp).world();
    let (device, queue) = (
        world.resource::<RenderDevice>(),
        world.resource::<RenderQueue>(),
    );
    let formulas = include_str!("../../../src/plugin/bump/bump.wgsl");
    let formulas = formulas.replace("#define_import_path bevy_fresco::bump", "");
    let source = formulas + include_str!("formulas.wgsl");
    let module = device.create_and_validate_shader_module(ShaderModuleDescriptor {
        label: None,
        source: ShaderSource::Wgsl(source.into()),
    });
    let pipeline = device.create_compute_pipeline(&RawComputePipelineDescriptor {
        label: None,
        layout: None,
        module: &module,
        entry_point: Some("main"),
        compilation_options: PipelineCompilationOptions::default(),
        cache: None,
    });
    let bytes: Vec<u8> = cases.iter().flat_map(Case::bytes).collect();
    let input = device.create_buffer_with_data(&BufferInitDescriptor {
        label: None,
        contents: &bytes,
        usage: BufferUsages::STORAGE,
    });
    let size = 32 * cases.len() as u64;
    let buffer = |usage| {
        device.create_buffer(&BufferDescriptor {
            label: None,
            size,
            usage,
            mapped_at_creation: false,
        })
    };
    let output = buffer(BufferUsages::STORAGE | BufferUsages::COPY_SRC);
    let read = buffer(BufferUsages::MAP_READ | BufferUsages::COPY_DST);
    let layout = pipeline.get_bind_group_layout(0);
    let group = device.create_bind_group(
        None,
        &layout.into(),
        &bevy::render::render_resource::BindGroupEntries::sequential((
            input.as_entire_binding(),
            output.as_entire_binding(),
        )),
    );
    let mut encoder = device.create_command_encoder(&CommandEncoderDescriptor::default());
    {
        let mut pass = encoder.begin_compute_pass(&ComputePassDescriptor::default());
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(0, &*group, &[]);
        pass.dispatch_workgroups((cases.len() as u32).div_ceil(64), 1, 1);
    }
    encoder.copy_buffer_to_buffer(&output, 0, &read, 0, size);
    queue.submit([encoder.finish()]);
    read.slice(..)
        .map_async(MapMode::Read, |done| done.unwrap());
    device.poll(PollType::wait_indefinitely()).unwrap();
    let bytes = read.slice(..).get_mapped_range();
    let floats: Vec<f32> = bytes
        .chunks_exact(4)
        .map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]]))
        .collect();
    floats
        .chunks_exact(8)
        .map(|v| [Vec4::from_slice(v), Vec4::from_slice(&v[4..])])
        .collect()
}

/// Bump test 3: no triangle gives anything but a unit normal, and those that have a truth have the true one.
#[test]
fn shader_and_twin_agree_on_all_triangles() {
    let cases = cases(100_000);
    let results = {
        let cases = cases.clone();
        on_stage(move |stage| run(stage, &cases))
    };
    assert_eq!(results.len(), cases.len());
    let (mut twin_off, mut truth_off, mut displaced_off, mut compared) =
        (0.0_f32, 0.0_f32, 0.0_f32, 0);
    for (case, [bumped, displaced]) in cases.iter().zip(&results) {
        let normals = [bumped, displaced].map(|n| n.truncate());
        for n in normals {
            assert!((n.length() - 1.0).abs() < 1e-5, "{n} of {:?}", case.steps);
        }
        let roughness = roughened(case.roughness, case.variance);
        assert!((bumped.w - roughness).abs() < 1e-4);
        let [a, b] = case.steps.along;
        let has_area = a.cross(b).length() > 0.01 * a.length() * b.length();
        if !has_area {
            continue;
        }
        compared += 1;
        let twin = bumped_normal(case.steps.normal, case.gradient());
        twin_off = twin_off.max(degrees(normals[0], twin));
        truth_off = truth_off.max(degrees(normals[0], case.truth()));
        let changes = case.uv.map(|uv| case.slopes.dot(uv));
        let twin = displaced_normal(case.steps, case.normal_changes, case.height, changes);
        displaced_off = displaced_off.max(degrees(normals[1], twin));
    }
    println!(
        "{compared} compared: twin {twin_off:.4}°, f64 {truth_off:.4}°, displaced {displaced_off:.4}°"
    );
    assert!(compared > 95_000);
    assert!(twin_off < 0.05 && truth_off < 0.5 && displaced_off < 0.1);
}
