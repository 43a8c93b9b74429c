//! Memory: what a picture will take, what there is, what was taken.

use crate::render::RenderError;
use etendue_film::{Allocation, Replicates};
use etendue_solvers::{Spread, Stop};

/// What a render holds besides its scene.
#[derive(Clone, Copy, Debug)]
pub struct Need {
    /// Pixels of the picture.
    pub size: [u32; 2],
    /// When it stops: a noise target needs replicates.
    pub stop: Stop,
    /// How it spreads its samples.
    pub spread: Spread,
    /// Bytes of the finished layers, per pixel.
    pub layer_bytes: u64,
    /// Bytes that the solver's state holds.
    pub solver_bytes: u64,
    /// Whether checkpoints are made.
    pub checkpoints: bool,
    /// Whether it goes on from a checkpoint, which is held meanwhile.
    pub resumes: bool,
}

impl Need {
    /// Bytes of exact sums per pixel: three channels and a weight of 16 bytes each.
    const SUMS: u64 = 4 * 16;
    /// Bytes per pixel while the picture is developed and written: f32 colours, as many again shown on a display, and the file.
    const PICTURES: u64 = 4 * 12;
    /// Bytes per pixel of a checkpoint: a copy of the sums, and its encoding, whose numbers take 13 bytes each after a thousand samples.
    const CHECKPOINT: u64 = Self::SUMS + 4 * 13;

    /// Of a picture and nothing besides.
    pub const fn least(size: [u32; 2]) -> Self {
        Self {
            size,
            stop: Stop::Samples(1),
            spread: Spread::Uniform,
            layer_bytes: 0,
            solver_bytes: 0,
            checkpoints: false,
            resumes: false,
        }
    }

    /// The most bytes that are held at one time.
    pub fn bytes(&self) -> u64 {
        let pixels = u64::from(self.size[0]) * u64::from(self.size[1]);
        let checkpoint = if self.checkpoints { Self::CHECKPOINT } else { 0 };
        let resumed = if self.resumes { Self::SUMS } else { 0 };
        // Films and finished pictures are not held together, but for the layers.
        let rendering = Self::SUMS + self.layer_bytes + resumed + checkpoint.max(12);
        let writing = Self::PICTURES + 2 * self.layer_bytes;
        let replicates = match self.stop {
            Stop::Noise { .. } => {
                let adaptive = self.spread == Spread::Adaptive;
                let allocation = if adaptive { pixels.saturating_mul(Allocation::BYTES) } else { 0 };
                allocation.saturating_add(Replicates::bytes(pixels, adaptive))
            }
            _ => 0,
        };
        pixels
            .saturating_mul(rendering)
            .saturating_add(self.solver_bytes)
            .max(pixels.saturating_mul(writing))
            .saturating_add(replicates)
    }

    /// Refuses what cannot fit, before anything is begun.
    pub(crate) fn check(&self) -> Result<(), RenderError> {
        match available() {
            Some(available) if self.bytes() > available => {
                let solver = match self.solver_bytes {
                    0 => String::new(),
                    bytes => format!(", {} of them for what the solver keeps of a pass,", human(bytes)),
                };
                Err(RenderError(format!(
                    "a picture of {} x {} pixels takes {}{solver} and {} can be had\n  help: make it smaller with --width and --height{}",
                    self.size[0],
                    self.size[1],
                    human(self.bytes()),
                    human(available),
                    if self.solver_bytes > 0 { ", or shoot fewer photons: --param photons=N" } else { "" }
                )))
            }
            _ => Ok(()),
        }
    }
}

/// The most memory that the process has held, bytes; zero where the system does not tell.
pub fn peak() -> u64 {
    proc_field("/proc/self/status", "VmHWM:").unwrap_or(0)
}

/// Memory that can still be had, bytes; `None` where the system does not tell.
pub fn available() -> Option<u64> {
    let free = proc_field("/proc/meminfo", "MemAvailable:")?;
    Some(cgroup_room().map_or(free, |room| room.min(free)))
}

/// What a container's limit leaves.
fn cgroup_room() -> Option<u64> {
    let read = |name: &str| std::fs::read_to_string(format!("/sys/fs/cgroup/{name}")).ok()?.trim().parse::<u64>().ok();
    Some(read("memory.max")?.saturating_sub(read("memory.current")?))
}

/// A `Name:   123 kB` line.
fn proc_field(file: &str, field: &str) -> Option<u64> {
    let text = std::fs::read_to_string(file).ok()?;
    let line = text.lines().find_map(|l| l.strip_prefix(field))?;
    Some(line.split_whitespace().next()?.parse::<u64>().ok()? * 1024)
}

/// A number of bytes for people.
pub fn human(bytes: u64) -> String {
    let b = bytes as f64;
    match bytes {
        0..=9_999 => format!("{bytes} B"),
        10_000..=9_999_999 => format!("{:.0} KiB", b / 1024.0),
        10_000_000..=9_999_999_999 => format!("{:.0} MiB", b / (1024.0 * 1024.0)),
        _ => format!("{:.1} GiB", b / (1024.0 * 1024.0 * 1024.0)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What a solver keeps of a pass counts: a picture of one pixel is refused for it, in words that name it.
    #[test]
    fn solvers_need_memory_too() {
        let pixel = Need::least([1, 1]);
        assert!(pixel.check().is_ok());
        let greedy = Need { solver_bytes: 1 << 60, ..pixel };
        assert!(greedy.bytes() >= 1 << 60);
        if available().is_some() {
            let words = greedy.check().expect_err("more than there is").to_string();
            assert!(words.contains("of a pass") && words.contains("--param photons=N"), "{words}");
        }
    }
}
