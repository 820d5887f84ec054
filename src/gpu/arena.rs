//! Packs the buffers of a plan into few allocations by their lifetimes.
//!
//! WebGPU tracks use per allocation, not per range: within one dispatch an allocation is either read
//! or written. So buffers share an allocation only where no step reads one and writes another.

use crate::gpu::plan::{BufferId, Plan, Role};

/// What an allocation is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Uniforms and uploads, filled by one copy a frame.
    Host,
    /// Filled once.
    Fixed,
    /// One buffer of the store, kept from submission to submission.
    Resident,
    /// Scratch buffers, by lifetime.
    Scratch,
}

/// One allocation.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Arena {
    /// What it is for.
    pub kind: Kind,
    /// Size in bytes.
    pub bytes: u64,
    members: Vec<BufferId>,
}

impl Arena {
    /// The resident buffer that it is, if it is one.
    pub(crate) fn resident(&self) -> Option<BufferId> {
        self.members.first().copied().filter(|_| self.kind == Kind::Resident)
    }
}

/// Where a buffer lies.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Place {
    /// Which allocation.
    pub arena: usize,
    /// Bytes from its start.
    pub offset: u64,
}

/// All allocations of a plan and the place of each buffer.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Layout {
    /// The allocations.
    pub arenas: Vec<Arena>,
    /// Place of each buffer, counted as [`BufferId`]; of no meaning for textures.
    pub places: Vec<Place>,
}

impl Layout {
    /// Places every buffer of `plan` (textures have memory of their own), each at a multiple of `alignment` bytes.
    pub fn pack(plan: &Plan, alignment: u64) -> Self {
        let mut layout = Self { arenas: Vec::new(), places: vec![Place::default(); plan.buffers().len()] };
        let ids =
            || (0..plan.buffers().len()).map(BufferId).filter(|id| plan.buffers()[id.0].texture.is_none());
        for id in ids() {
            match plan.buffers()[id.0].role {
                Role::Uniform(..) | Role::Upload => layout.append(plan, id, Kind::Host, alignment),
                Role::Fixed(_) => layout.append(plan, id, Kind::Fixed, alignment),
                Role::State => layout.open(plan, id, Kind::Resident),
                Role::Scratch => {}
            }
        }
        let mut scratch: Vec<_> = ids().filter(|id| plan.buffers()[id.0].role == Role::Scratch).collect();
        scratch.sort_by_key(|id| std::cmp::Reverse(plan.buffers()[id.0].bytes));
        for id in scratch {
            layout.place_scratch(plan, id, alignment);
        }
        layout
    }

    fn open(&mut self, plan: &Plan, id: BufferId, kind: Kind) {
        self.places[id.0] = Place { arena: self.arenas.len(), offset: 0 };
        self.arenas.push(Arena { kind, bytes: plan.buffers()[id.0].bytes, members: vec![id] });
    }

    fn append(&mut self, plan: &Plan, id: BufferId, kind: Kind, alignment: u64) {
        let Some(arena) = self.arenas.iter().position(|a| a.kind == kind) else {
            return self.open(plan, id, kind);
        };
        let offset = self.arenas[arena].bytes.next_multiple_of(alignment);
        self.put(plan, id, Place { arena, offset });
    }

    fn put(&mut self, plan: &Plan, id: BufferId, place: Place) {
        let arena = &mut self.arenas[place.arena];
        arena.bytes = arena.bytes.max(place.offset + plan.buffers()[id.0].bytes);
        arena.members.push(id);
        self.places[id.0] = place;
    }

    fn place_scratch(&mut self, plan: &Plan, id: BufferId, alignment: u64) {
        let fitting = (0..self.arenas.len())
            .filter(|&a| self.arenas[a].kind == Kind::Scratch && may_share(plan, &self.arenas[a].members, id))
            .map(|arena| Place { arena, offset: self.free_offset(plan, arena, id, alignment) })
            .min_by_key(|place| {
                let grown = (place.offset + plan.buffers()[id.0].bytes)
                    .saturating_sub(self.arenas[place.arena].bytes);
                (grown, place.arena)
            });
        match fitting {
            Some(place) => self.put(plan, id, place),
            None => self.open(plan, id, Kind::Scratch),
        }
    }

    /// The lowest offset at which no buffer alive at the same time lies.
    fn free_offset(&self, plan: &Plan, arena: usize, id: BufferId, alignment: u64) -> u64 {
        let bytes = plan.buffers()[id.0].bytes;
        let mut taken: Vec<(u64, u64)> = self.arenas[arena]
            .members
            .iter()
            .filter(|member| overlap(plan.lifetime(**member), plan.lifetime(id)))
            .map(|member| (self.places[member.0].offset, plan.buffers()[member.0].bytes))
            .collect();
        taken.sort_unstable();
        let mut offset = 0;
        for (start, size) in taken {
            if offset + bytes <= start {
                break;
            }
            offset = offset.max((start + size).next_multiple_of(alignment));
        }
        offset
    }
}

/// Whether no step reads one of the buffers and writes another of them.
fn may_share(plan: &Plan, members: &[BufferId], id: BufferId) -> bool {
    plan.steps().iter().all(|step| {
        let mut writes = step
            .uses()
            .filter(|(_, used)| *used == id || members.contains(used))
            .map(|(binding, _)| binding.access.writes());
        match writes.next() {
            Some(first) => writes.all(|other| other == first),
            None => true,
        }
    })
}

fn overlap(a: Option<(usize, usize)>, b: Option<(usize, usize)>) -> bool {
    match (a, b) {
        (Some((a0, a1)), Some((b0, b1))) => a0 <= b1 && b0 <= a1,
        _ => false,
    }
}
