//! The plan of a frame: named buffers and ordered steps, checked for order and hazards without a GPU.

use crate::base::{Error, Result};
use crate::gpu::context::Requirements;
use crate::gpu::parts::layout_difference;
pub use crate::gpu::parts::{BufferDecl, BufferId, Extent, Invocations, Role, Step};
use crate::gpu::shader::{Access, Binding, Params, Shader, ShaderText};

/// Buffers and steps of one frame. Stages append to it; the executor builds it.
#[derive(Debug, Clone, Default)]
pub struct Plan {
    buffers: Vec<BufferDecl>,
    steps: Vec<Step>,
    scope: String,
}

/// The name of a buffer of `scope`.
pub(crate) fn scoped(scope: &str, name: &str) -> String {
    if scope.is_empty() { name.into() } else { format!("{scope}/{name}") }
}

impl Plan {
    /// Declared buffers; a [`BufferId`] counts them.
    pub fn buffers(&self) -> &[BufferDecl] {
        &self.buffers
    }

    /// Steps in order.
    pub fn steps(&self) -> &[Step] {
        &self.steps
    }

    /// What is declared from here on belongs to `scope` (a sensor's name), and is looked up there first; empty: to no scope.
    pub fn enter(&mut self, scope: &str) {
        self.scope = scope.into();
    }

    /// Declares the parameters of a pass.
    ///
    /// # Errors
    /// [`Error::Plan`] where the name is taken.
    pub fn uniform<P: Params>(&mut self, name: &str) -> Result<BufferId> {
        self.declare(name, size_of::<P>() as u64, Role::Uniform(P::NAME, P::FIELDS))
    }

    /// Declares a buffer that the host fills before every frame.
    ///
    /// # Errors
    /// [`Error::Plan`] where the name is taken or the size is 0.
    pub fn upload(&mut self, name: &str, bytes: u64) -> Result<BufferId> {
        self.declare(name, bytes, Role::Upload)
    }

    /// Declares a buffer filled once.
    ///
    /// # Errors
    /// [`Error::Plan`] where the name is taken or there is no data.
    pub fn fixed(&mut self, name: &str, data: Vec<u8>) -> Result<BufferId> {
        self.declare(name, data.len() as u64, Role::Fixed(data))
    }

    /// Declares a buffer that keeps its content from frame to frame.
    ///
    /// # Errors
    /// [`Error::Plan`] where the name is taken or the size is 0.
    pub fn state(&mut self, name: &str, bytes: u64) -> Result<BufferId> {
        self.declare(name, bytes, Role::State)
    }

    /// Declares a resident buffer that belongs to no scope: all plans on one store share it. What this plan writes another may
    /// read.
    ///
    /// # Errors
    /// [`Error::Plan`] where the name is taken or the size is 0.
    pub fn shared(&mut self, name: &str, bytes: u64) -> Result<BufferId> {
        let scope = std::mem::take(&mut self.scope);
        let declared = self.declare(name, bytes, Role::State);
        self.scope = scope;
        let id = declared?;
        self.buffers[id.0].product = true;
        Ok(id)
    }

    /// Declares a buffer that lives within a frame.
    ///
    /// # Errors
    /// [`Error::Plan`] where the name is taken or the size is 0.
    pub fn scratch(&mut self, name: &str, bytes: u64) -> Result<BufferId> {
        self.declare(name, bytes, Role::Scratch)
    }

    /// Declares a buffer that lives within a frame and holds zeros at its start.
    ///
    /// # Errors
    /// [`Error::Plan`] where the name is taken or the size is 0.
    pub fn zeroed(&mut self, name: &str, bytes: u64) -> Result<BufferId> {
        let id = self.scratch(name, bytes)?;
        self.buffers[id.0].zeroed = true;
        Ok(id)
    }

    /// Declares a result of the frame, which lives within it and which the host may or may not read back.
    ///
    /// # Errors
    /// [`Error::Plan`] where the name is taken or the size is 0.
    pub fn product(&mut self, name: &str, bytes: u64) -> Result<BufferId> {
        let id = self.declare(name, bytes, Role::Scratch)?;
        self.buffers[id.0].product = true;
        Ok(id)
    }

    /// Declares a texture that lives within a frame.
    ///
    /// # Errors
    /// [`Error::Plan`] where the name is taken or an extent is 0.
    pub fn texture(&mut self, name: &str, extent: Extent) -> Result<BufferId> {
        let id = self.declare(name, extent.bytes(), Role::Scratch)?;
        self.buffers[id.0].texture = Some(extent);
        Ok(id)
    }

    /// Declares a texture of whole numbers (rgba32uint, one layer) that the host fills before every frame, row by row.
    ///
    /// # Errors
    /// [`Error::Plan`] where the name is taken, an extent is 0, or rows are no multiple of 16 texels, as copies want them.
    pub fn upload_texture(&mut self, name: &str, width: u32, height: u32) -> Result<BufferId> {
        if !width.is_multiple_of(16) {
            return Err(plan_error(name, &format!("has rows of {width} texels, no multiple of 16")));
        }
        let extent = Extent { width, height, layers: 1 };
        let id = self.declare(name, extent.bytes(), Role::Upload)?;
        self.buffers[id.0].texture = Some(extent);
        self.buffers[id.0].whole = true;
        Ok(id)
    }

    /// Declares a texture filled once, row by row.
    ///
    /// # Errors
    /// [`Error::Plan`] where the name is taken or `data` is not of that extent.
    pub fn fixed_texture(&mut self, name: &str, extent: Extent, data: Vec<u8>) -> Result<BufferId> {
        if data.len() as u64 != extent.bytes() {
            return Err(plan_error(name, &format!("{} bytes do not fill {extent:?}", data.len())));
        }
        let id = self.declare(name, extent.bytes(), Role::Fixed(data))?;
        self.buffers[id.0].texture = Some(extent);
        Ok(id)
    }

    fn declare(&mut self, name: &str, bytes: u64, role: Role) -> Result<BufferId> {
        let name = &scoped(&self.scope, name);
        if self.buffers.iter().any(|buffer| buffer.name == *name) {
            return Err(plan_error(name, "is declared twice"));
        }
        if bytes == 0 {
            return Err(plan_error(name, "has no bytes"));
        }
        let bytes = bytes.next_multiple_of(4);
        self.buffers.push(BufferDecl {
            name: name.into(),
            bytes,
            texture: None,
            whole: false,
            role,
            read_back: false,
            product: false,
            zeroed: false,
        });
        Ok(BufferId(self.buffers.len() - 1))
    }

    /// The buffer of that name: of the scope that the plan is in, else of none.
    pub fn find(&self, name: &str) -> Option<BufferId> {
        self.find_in(&self.scope, name)
    }

    /// The buffer of that name: of `scope`, else of none.
    pub fn find_in(&self, scope: &str, name: &str) -> Option<BufferId> {
        let named = |wanted: &str| self.buffers.iter().position(|buffer| buffer.name == wanted).map(BufferId);
        named(&scoped(scope, name)).or_else(|| named(name))
    }

    /// Reads the buffer back after every frame.
    ///
    /// # Errors
    /// [`Error::Plan`] where there is no such buffer.
    pub fn read_back(&mut self, name: &str) -> Result<BufferId> {
        let id = self.find(name).ok_or_else(|| plan_error(name, "is to be read back but not declared"))?;
        if self.buffers[id.0].texture.is_some() {
            return Err(plan_error(name, "is a texture; only buffers are read back"));
        }
        self.buffers[id.0].read_back = true;
        Ok(id)
    }

    /// Appends a pass over `invocations`; its variables bind the buffers of the same names, or of
    /// those that `renamed` gives as (variable, buffer).
    ///
    /// # Errors
    /// [`Error::Shader`] from the WGSL; [`Error::Plan`] where a variable has no buffer or does not fit it.
    pub fn step(
        &mut self,
        source: impl Into<ShaderText>,
        invocations: Invocations,
        renamed: &[(&str, &str)],
    ) -> Result<()> {
        let shader = Shader::parse(source)?;
        let mut buffers = Vec::with_capacity(shader.bindings.len());
        for binding in &shader.bindings {
            let name = renamed.iter().find(|(var, _)| *var == binding.name).map_or(&*binding.name, |r| r.1);
            let id = self.find(name).ok_or_else(|| {
                plan_error(
                    &shader.name,
                    &format!("`{}` needs a buffer `{name}`, which nothing declares", binding.name),
                )
            })?;
            self.check_fit(&shader.name, binding, id)?;
            buffers.push(id);
        }
        let workgroups = invocations.workgroups(shader.workgroup_size);
        if workgroups.contains(&0) {
            return Err(plan_error(&shader.name, "has nothing to do: an extent is 0"));
        }
        let scope = self.scope.clone();
        self.steps.push(Step { scope, shader, workgroups, buffers, constants: Vec::new() });
        Ok(())
    }

    /// Sets `override` constants of the step appended last.
    ///
    /// # Errors
    /// [`Error::Plan`] where there is no step or its shader has no such constant.
    pub fn with<V: Copy + Into<f64>>(&mut self, constants: &[(&'static str, V)]) -> Result<()> {
        let step = self.steps.last_mut().ok_or_else(|| plan_error("with", "needs a step before it"))?;
        for (name, value) in constants {
            if !step.shader.overrides.iter().any(|known| known == name) {
                return Err(plan_error(&step.shader.name, &format!("has no override `{name}`")));
            }
            step.constants.push((name, (*value).into()));
        }
        Ok(())
    }

    fn check_fit(&self, pass: &str, binding: &Binding, id: BufferId) -> Result<()> {
        let buffer = &self.buffers[id.0];
        let bad = |reason: String| Err(plan_error(pass, &format!("`{}` {reason}", binding.name)));
        match (&buffer.role, binding.access) {
            (Role::Uniform(name, fields), Access::Uniform) => {
                if let Some(difference) = layout_difference(binding, name, fields, buffer.bytes) {
                    return bad(difference);
                }
            }
            (Role::Uniform(..), _) | (_, Access::Uniform) => {
                return bad(format!("and buffer `{}` disagree on being uniform", buffer.name));
            }
            _ => {}
        }
        if binding.texture != buffer.texture.is_some() {
            let kind = |texture| if texture { "texture" } else { "buffer" };
            let [is, declared] = [kind(binding.texture), kind(buffer.texture.is_some())];
            return bad(format!("is a {is} in WGSL, `{}` a {declared} of the plan", buffer.name));
        }
        if binding.whole != buffer.whole {
            return bad(format!("and texture `{}` disagree on texels being whole numbers", buffer.name));
        }
        if buffer.bytes < binding.min_bytes {
            return bad(format!(
                "needs {} bytes, buffer `{}` has {}",
                binding.min_bytes, buffer.name, buffer.bytes
            ));
        }
        if binding.access.writes() && matches!(buffer.role, Role::Upload | Role::Fixed(_)) {
            return bad(format!("writes buffer `{}`, which only the host may write", buffer.name));
        }
        Ok(())
    }

    /// Checks the whole plan: every scratch buffer is written before it is read, nothing is bound
    /// twice where one use writes, every buffer is used.
    ///
    /// # Errors
    /// [`Error::Plan`] that names pass and buffer.
    pub fn check(&self) -> Result<()> {
        let mut written: Vec<bool> =
            self.buffers.iter().map(|b| b.role != Role::Scratch || b.zeroed).collect();
        let mut used = vec![false; self.buffers.len()];
        for step in &self.steps {
            self.check_aliases(step)?;
            for (binding, id) in step.uses() {
                if binding.access.reads() && !written[id.0] {
                    let name = &self.buffers[id.0].name;
                    return Err(plan_error(
                        &step.shader.name,
                        &format!("reads `{name}` before any pass has written it"),
                    ));
                }
                used[id.0] |= binding.access.reads();
            }
            for (_, id) in step.uses().filter(|(binding, _)| binding.access.writes()) {
                written[id.0] = true;
            }
        }
        for (buffer, (written, used)) in self.buffers.iter().zip(written.iter().zip(&used)) {
            if !used && !buffer.read_back && !buffer.product {
                return Err(plan_error(&buffer.name, "is never read"));
            }
            if buffer.read_back && !written {
                return Err(plan_error(&buffer.name, "is read back but never written"));
            }
        }
        Ok(())
    }

    fn check_aliases(&self, step: &Step) -> Result<()> {
        let uses: Vec<_> = step.uses().collect();
        for (i, (a, buffer)) in uses.iter().enumerate() {
            let twice = uses[i + 1..]
                .iter()
                .find(|(b, other)| other == buffer && (a.access.writes() || b.access.writes()));
            if let Some((b, _)) = twice {
                return Err(plan_error(
                    &step.shader.name,
                    &format!(
                        "binds `{}` as `{}` and as `{}`, and writes it",
                        self.buffers[buffer.0].name, a.name, b.name
                    ),
                ));
            }
        }
        Ok(())
    }

    /// First and last step that uses the buffer; the first is 0 where the frame begins with it zeroed, the last the number
    /// of steps where it is read back.
    pub fn lifetime(&self, id: BufferId) -> Option<(usize, usize)> {
        let mut uses =
            self.steps.iter().enumerate().filter(|(_, step)| step.buffers.contains(&id)).map(|(i, _)| i);
        let first = uses.next()?;
        let last =
            if self.buffers[id.0].read_back { self.steps.len() } else { uses.next_back().unwrap_or(first) };
        Some((if self.buffers[id.0].zeroed { 0 } else { first }, last))
    }

    /// What a device must offer to run this plan.
    pub fn requirements(&self) -> Requirements {
        let count = |wanted: fn(&Binding) -> bool| {
            let of_step = |s: &Step| s.shader.bindings.iter().filter(|b| wanted(b)).count();
            self.steps.iter().map(of_step).max().unwrap_or(0)
        };
        let buffers = || self.buffers.iter().filter(|b| b.texture.is_none());
        let textures = || self.buffers.iter().filter_map(|b| b.texture);
        Requirements {
            largest_buffer_bytes: buffers().map(|b| b.bytes).max().unwrap_or(0),
            upload_bytes: self.host_buffers().map(|b| b.bytes.next_multiple_of(256)).sum(),
            storage_buffers: count(|b| b.access != Access::Uniform && !b.texture),
            storage_textures: count(|b| b.texture),
            texture_side: textures().map(|t| t.width.max(t.height)).max().unwrap_or(0),
            texture_layers: textures().map(|t| t.layers).max().unwrap_or(0),
            subgroups: self.steps.iter().any(|s| s.shader.subgroups),
            invocations: self
                .steps
                .iter()
                .map(|s| s.shader.workgroup_size.iter().product())
                .max()
                .unwrap_or(1),
            workgroups: self.steps.iter().flat_map(|s| s.workgroups).max().unwrap_or(1),
        }
    }

    fn host_buffers(&self) -> impl Iterator<Item = &BufferDecl> {
        self.buffers.iter().filter(|b| matches!(b.role, Role::Uniform(..) | Role::Upload))
    }

    /// The table of passes as Markdown: pass, workgroups, what it reads and what it writes.
    pub fn table(&self) -> String {
        let mut text = String::from("| pass | reads | writes |\n|---|---|---|\n");
        for step in &self.steps {
            let names = |wanted: fn(Access) -> bool| {
                let names: Vec<_> = step
                    .uses()
                    .filter(|(b, _)| b.access != Access::Uniform && wanted(b.access))
                    .map(|(_, id)| self.buffers[id.0].name.as_str())
                    .collect();
                names.join(", ")
            };
            text +=
                &format!("| {} | {} | {} |\n", step.shader.name, names(Access::reads), names(Access::writes));
        }
        text
    }
}

fn plan_error(pass: &str, reason: &str) -> Error {
    Error::Plan { pass: pass.into(), reason: reason.into() }
}
