use glam::Vec3;

use super::color::luminance;
use super::fit::{Fit, Samples, solve};
use super::gathered::TriangleSamples;
use super::parallel::Cancelled;
use super::receivers::Receivers;

/// How the light of one vertex was found, and how sure it is.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct VertexQuality {
    /// What chance leaves in its light: half the difference of fits to half of the samples each, luminance / π in
    /// cd/m². One vertex's own is a guess; many beside each other tell where rays are scarce.
    pub error: f32,
    /// Samples of light around it, for each square metre.
    pub samples: f32,
    /// Where its light is from.
    pub source: VertexSource,
}

/// Where the light of a vertex is from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum VertexSource {
    /// From samples around it.
    #[default]
    Sampled,
    /// All samples around it lie inside geometry: its light is that of its neighbours along the mesh.
    Filled,
    /// All samples of its piece of mesh lie inside geometry: it is black.
    Buried,
}

/// Judges every unknown of the fine meshes. `square` is the area of a square metre in squared internal units.
pub(crate) fn judge(
    samples: &Samples,
    receivers: &Receivers,
    fitted: &Fit,
    square: f32,
    go_on: &dyn Fn() -> bool,
) -> Result<Vec<VertexQuality>, Cancelled> {
    let unknowns = [receivers.coarse.unknowns, receivers.fine.unknowns];
    let apart = |samples: &[TriangleSamples], unknowns: usize, lambda: f32| {
        if !go_on() {
            return Err(Cancelled);
        }
        let [a, b] = [0, 1].map(|half| solve(samples, unknowns, &[half], lambda));
        Ok(a.iter().zip(b).map(|(&a, b)| a - b).collect::<Vec<_>>())
    };
    let lambda = fitted.smoothing.lambda;
    let smooth = apart(samples.smooth, unknowns[0], lambda.smooth)?;
    let sharp = apart(samples.sharp, unknowns[1], lambda.sharp)?;
    let smooth = receivers.carried_over(&smooth);
    let coarse = receivers.carried_over(&density(samples.smooth, unknowns[0]));
    let fine = density(samples.sharp, unknowns[1]);
    let of = |u: usize| VertexQuality {
        error: 0.5 * luminance(smooth[u] + sharp[u]).abs(),
        samples: (coarse[u].x + fine[u].x) * square,
        source: match (fitted.filled[u], fitted.dark[u]) {
            (_, true) => VertexSource::Buried,
            (true, _) => VertexSource::Filled,
            _ => VertexSource::Sampled,
        },
    };
    Ok((0..unknowns[1]).map(of).collect())
}

/// Valid samples around each unknown for each unit of area, in all three channels.
fn density(samples: &[TriangleSamples], unknowns: usize) -> Vec<Vec3> {
    let mut sums = vec![(0.0_f32, 0.0_f32); unknowns];
    for triangle in samples {
        let valid = triangle.taken - triangle.invalid;
        for &u in &triangle.unknowns {
            let (taken, area) = &mut sums[u as usize];
            *taken += valid as f32;
            *area += triangle.area;
        }
    }
    let each = |(taken, area): (f32, f32)| Vec3::splat(taken / area.max(f32::MIN_POSITIVE));
    sums.into_iter().map(each).collect()
}
