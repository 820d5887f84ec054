//! GPU time of each pass by timestamp queries.

use crate::gpu::context::Context;

/// A pair of timestamps per pass, resolved into a buffer that the frame's readback copies.
pub(crate) struct Timing {
    queries: wgpu::QuerySet,
    pub(crate) resolved: wgpu::Buffer,
    passes: u32,
    period_ns: f64,
}

impl Timing {
    /// `None` where the device was opened without timestamps.
    pub(crate) fn new(context: &Context, passes: u32) -> Option<Self> {
        let device = &context.device;
        if !device.features().contains(wgpu::Features::TIMESTAMP_QUERY) || passes == 0 {
            return None;
        }
        let queries = device.create_query_set(&wgpu::QuerySetDescriptor {
            label: Some("pass times"),
            ty: wgpu::QueryType::Timestamp,
            count: 2 * passes,
        });
        let resolved = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("pass times"),
            size: u64::from(passes) * 16,
            usage: wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC,
            mapped_at_creation: false,
        });
        let period_ns = f64::from(context.queue.get_timestamp_period());
        Some(Self { queries, resolved, passes, period_ns })
    }

    pub(crate) fn writes(&self, pass: u32) -> wgpu::ComputePassTimestampWrites<'_> {
        wgpu::ComputePassTimestampWrites {
            query_set: &self.queries,
            beginning_of_pass_write_index: Some(2 * pass),
            end_of_pass_write_index: Some(2 * pass + 1),
        }
    }

    pub(crate) fn resolve(&self, encoder: &mut wgpu::CommandEncoder) {
        encoder.resolve_query_set(&self.queries, 0..2 * self.passes, &self.resolved, 0);
    }

    /// Start and length of each pass in nanoseconds, the first pass starting at 0.
    pub(crate) fn spans(&self, ticks: &[u8]) -> Vec<PassSpan> {
        let ticks: Vec<u64> = ticks.chunks_exact(8).map(bytemuck::pod_read_unaligned).collect();
        let first = ticks.iter().copied().min().unwrap_or(0);
        #[expect(clippy::cast_precision_loss, reason = "a frame's ticks fit in 53 bits")]
        let ns = |from: u64, to: u64| to.saturating_sub(from) as f64 * self.period_ns;
        ticks
            .chunks_exact(2)
            .map(|t| PassSpan { start_ns: ns(first, t[0]), length_ns: ns(t[0], t[1]) })
            .collect()
    }
}

/// When a pass ran.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PassSpan {
    /// Nanoseconds on the GPU's clock.
    pub start_ns: f64,
    /// Nanoseconds.
    pub length_ns: f64,
}
