//! WGSL files read with naga: a pass is declared by its file alone.

use naga::valid::{Capabilities, GlobalUse, ValidationFlags, Validator};

use crate::error::{Error, Result};

/// The text of one pass: its own file last, shared library files before it.
#[derive(Debug, Clone, Copy)]
pub struct ShaderSource {
    /// Label of the pass, `stem` or `stem/file`; the last part is the entry point's name.
    pub name: &'static str,
    /// WGSL texts in order of concatenation.
    pub parts: &'static [&'static str],
}

/// What a pass does with a buffer, from its declaration and its code.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Access {
    /// `var<uniform>`.
    Uniform,
    /// `var<storage, read>`.
    Read,
    /// `var<storage, read_write>` that the code only stores to.
    Write,
    /// `var<storage, read_write>` that the code loads from or updates atomically.
    ReadWrite,
}

impl Access {
    /// Whether the pass needs what was there before.
    pub fn reads(self) -> bool {
        self != Self::Write
    }

    /// Whether the pass changes the buffer.
    pub fn writes(self) -> bool {
        matches!(self, Self::Write | Self::ReadWrite)
    }
}

/// One buffer variable of a pass.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Binding {
    /// The WGSL variable's name.
    pub name: String,
    /// `@binding`; all are in group 0.
    pub slot: u32,
    /// Use of the buffer.
    pub access: Access,
    /// Bytes of the fixed part, and one element where the buffer ends in a runtime-sized array.
    pub min_bytes: u64,
    /// Field names and byte offsets where the variable is a struct.
    pub fields: Vec<(String, u32)>,
    /// Name of the variable's struct type, empty otherwise.
    pub type_name: String,
}

/// A parsed and validated pass.
#[derive(Debug, Clone)]
pub struct Shader {
    /// Label of the pass.
    pub name: &'static str,
    /// Name of the entry point.
    pub entry_point: String,
    /// The concatenated WGSL.
    pub source: String,
    /// Invocations per workgroup.
    pub workgroup_size: [u32; 3],
    /// Buffers, in order of their slots.
    pub bindings: Vec<Binding>,
    /// Names of its `override` constants.
    pub overrides: Vec<String>,
}

/// A parameter struct shared with WGSL: same name, same field names, same offsets.
pub trait Params: bytemuck::Pod {
    /// The struct's name in WGSL.
    const NAME: &'static str;
    /// Field names and byte offsets.
    const FIELDS: &'static [(&'static str, usize)];
}

/// Declares a parameter struct with its [`Params`] layout.
#[macro_export]
macro_rules! params {
    ($(#[$meta:meta])* pub struct $name:ident { $($(#[$field_meta:meta])* pub $field:ident: $ty:ty,)* }) => {
        $(#[$meta])*
        #[repr(C)]
        #[derive(Debug, Clone, Copy, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
        pub struct $name { $($(#[$field_meta])* pub $field: $ty,)* }
        impl $crate::gpu::Params for $name {
            const NAME: &'static str = stringify!($name);
            const FIELDS: &'static [(&'static str, usize)] =
                &[$((stringify!($field), std::mem::offset_of!($name, $field)),)*];
        }
    };
}

impl Shader {
    /// Parses and validates `source`.
    ///
    /// # Errors
    /// [`Error::Shader`] with naga's message, or where the file breaks a rule of the house: one
    /// compute entry point named as the file, all buffers used and in group 0.
    pub fn parse(source: ShaderSource) -> Result<Self> {
        let text = source.parts.join("\n");
        let bad = |reason: String| Error::Shader { pass: source.name.into(), reason };
        let module = naga::front::wgsl::parse_str(&text)
            .map_err(|e| bad(e.emit_to_string_with_path(&text, source.name)))?;
        let info = Validator::new(ValidationFlags::all(), Capabilities::all())
            .validate(&module)
            .map_err(|e| bad(e.emit_to_string_with_path(&text, source.name)))?;
        let stem = source.name.rsplit('/').next().unwrap_or(source.name);
        let [entry] = module.entry_points.as_slice() else {
            return Err(bad(format!("has {} entry points; one is wanted", module.entry_points.len())));
        };
        if entry.name != stem {
            return Err(bad(format!("entry point `{}` is not named as its file `{stem}`", entry.name)));
        }
        let mut bindings = module
            .global_variables
            .iter()
            .filter_map(|(handle, var)| Some((handle, var, var.binding?)))
            .map(|(handle, var, at)| {
                let usage = info.get_entry_point(0)[handle];
                binding(&module, var, at, usage).map_err(bad)
            })
            .collect::<Result<Vec<_>>>()?;
        bindings.sort_by_key(|b| b.slot);
        Ok(Self {
            name: source.name,
            entry_point: entry.name.clone(),
            workgroup_size: entry.workgroup_size,
            source: text,
            bindings,
            overrides: module.overrides.iter().filter_map(|(_, o)| o.name.clone()).collect(),
        })
    }
}

fn binding(
    module: &naga::Module,
    var: &naga::GlobalVariable,
    at: naga::ResourceBinding,
    usage: GlobalUse,
) -> std::result::Result<Binding, String> {
    let name = var.name.clone().unwrap_or_default();
    if at.group != 0 {
        return Err(format!("`{name}` is in group {}; all buffers go in group 0", at.group));
    }
    if usage.is_empty() {
        return Err(format!("`{name}` is declared but not used"));
    }
    let ty = &module.types[var.ty];
    let fields = match &ty.inner {
        naga::TypeInner::Struct { members, .. } => {
            members.iter().map(|m| (m.name.clone().unwrap_or_default(), m.offset)).collect()
        }
        _ => Vec::new(),
    };
    Ok(Binding {
        access: access(var.space, usage).ok_or_else(|| format!("`{name}` is not a buffer"))?,
        slot: at.binding,
        min_bytes: u64::from(ty.inner.size(module.to_ctx())),
        type_name: if fields.is_empty() { String::new() } else { ty.name.clone().unwrap_or_default() },
        fields,
        name,
    })
}

fn access(space: naga::AddressSpace, usage: GlobalUse) -> Option<Access> {
    match space {
        naga::AddressSpace::Uniform => Some(Access::Uniform),
        naga::AddressSpace::Storage { access } if !access.contains(naga::StorageAccess::STORE) => {
            Some(Access::Read)
        }
        naga::AddressSpace::Storage { .. } if usage.contains(GlobalUse::READ) => Some(Access::ReadWrite),
        naga::AddressSpace::Storage { .. } => Some(Access::Write),
        _ => None,
    }
}
