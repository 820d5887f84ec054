//! WGSL files read with naga: a pass is declared by its file alone.

use naga::valid::{Capabilities, GlobalUse, ShaderStages, SubgroupOperationSet, ValidationFlags, Validator};

use crate::base::{Error, Result};
use crate::gpu::loops::all_counted;

/// The text of one pass: its own file last, shared library files before it.
#[derive(Debug, Clone, Copy)]
pub struct ShaderSource {
    /// Label of the pass, `stem` or `stem/file`; the last part is the entry point's name.
    pub name: &'static str,
    /// WGSL texts in order of concatenation.
    pub parts: &'static [&'static str],
}

/// The text of a pass put together for one use: a label of its own, and parts chosen by the host.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ShaderText {
    /// Label of the pass.
    pub label: String,
    /// Name of the entry point.
    pub entry_point: &'static str,
    /// The concatenated WGSL.
    pub text: String,
}

impl From<ShaderSource> for ShaderText {
    fn from(source: ShaderSource) -> Self {
        let entry_point = source.name.rsplit('/').next().unwrap_or(source.name);
        Self { label: source.name.into(), entry_point, text: source.parts.join("\n") }
    }
}

/// What a pass does with a buffer, from its declaration and its code.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Access {
    /// `var<uniform>`.
    Uniform,
    /// `var<storage, read>`, or a storage texture of `read` access.
    Read,
    /// `var<storage, read_write>` that the code only stores to, or a storage texture of `write` access.
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
    /// Whether it is a storage texture.
    pub texture: bool,
    /// Whether its texels are whole numbers.
    pub whole: bool,
}

/// A parsed and validated pass.
#[derive(Debug, Clone)]
pub struct Shader {
    /// Label of the pass.
    pub name: String,
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
    /// Whether it uses subgroup operations.
    pub subgroups: bool,
    /// Whether all its loops are proven to end: each counts up to a constant.
    pub counted_loops: bool,
}

/// A parameter struct shared with WGSL: same name, same field names, same offsets.
pub trait Params: bytemuck::Pod {
    /// The struct's name in WGSL.
    const NAME: &'static str;
    /// Field names and byte offsets.
    const FIELDS: &'static [(&'static str, usize)];
}

/// Declares a parameter struct with its [`Params`] layout.
#[doc(hidden)]
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
    pub fn parse(source: impl Into<ShaderText>) -> Result<Self> {
        let ShaderText { label, entry_point, text } = source.into();
        let bad = |reason: String| Error::Shader { pass: label.clone(), reason };
        let module = naga::front::wgsl::parse_str(&text)
            .map_err(|e| bad(e.emit_to_string_with_path(&text, &label)))?;
        let info = Validator::new(ValidationFlags::all(), Capabilities::all())
            .subgroup_stages(ShaderStages::all())
            .subgroup_operations(SubgroupOperationSet::all())
            .validate(&module)
            .map_err(|e| bad(e.emit_to_string_with_path(&text, &label)))?;
        let [entry] = module.entry_points.as_slice() else {
            return Err(bad(format!("has {} entry points; one is wanted", module.entry_points.len())));
        };
        if entry.name != entry_point {
            return Err(bad(format!(
                "entry point `{}` is not named as its file `{entry_point}`",
                entry.name
            )));
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
            entry_point: entry.name.clone(),
            workgroup_size: entry.workgroup_size,
            bindings,
            overrides: module.overrides.iter().filter_map(|(_, o)| o.name.clone()).collect(),
            subgroups: uses_subgroups(&module),
            counted_loops: all_counted(&module),
            name: label,
            source: text,
        })
    }
}

/// Whether any function of the module gathers across a subgroup.
fn uses_subgroups(module: &naga::Module) -> bool {
    let functions = module.functions.iter().map(|(_, f)| f);
    functions.chain(module.entry_points.iter().map(|e| &e.function)).any(|function| {
        let mut expressions = function.expressions.iter().map(|(_, expression)| expression);
        expressions.any(|e| matches!(e, naga::Expression::SubgroupOperationResult { .. }))
    })
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
        access: access(var.space, &ty.inner, usage).ok_or_else(|| {
            format!("`{name}` is neither a buffer nor a storage texture array of rgba32float or rgba32uint")
        })?,
        slot: at.binding,
        min_bytes: u64::from(ty.inner.size(module.to_ctx())),
        type_name: if fields.is_empty() { String::new() } else { ty.name.clone().unwrap_or_default() },
        texture: matches!(ty.inner, naga::TypeInner::Image { .. }),
        whole: texture_of(&ty.inner).is_some_and(|(format, _)| format == naga::StorageFormat::Rgba32Uint),
        fields,
        name,
    })
}

fn access(space: naga::AddressSpace, ty: &naga::TypeInner, usage: GlobalUse) -> Option<Access> {
    match space {
        naga::AddressSpace::Handle => texture_access(ty),
        naga::AddressSpace::Uniform => Some(Access::Uniform),
        naga::AddressSpace::Storage { access } if !access.contains(naga::StorageAccess::STORE) => {
            Some(Access::Read)
        }
        naga::AddressSpace::Storage { .. } if usage.contains(GlobalUse::READ) => Some(Access::ReadWrite),
        naga::AddressSpace::Storage { .. } => Some(Access::Write),
        _ => None,
    }
}

/// Format and access of a storage texture array of a supported format.
fn texture_of(ty: &naga::TypeInner) -> Option<(naga::StorageFormat, naga::StorageAccess)> {
    use naga::{ImageClass, ImageDimension, StorageFormat, TypeInner};
    let TypeInner::Image { dim: ImageDimension::D2, arrayed: true, class } = ty else { return None };
    let ImageClass::Storage { format, access } = class else { return None };
    let supported = matches!(format, StorageFormat::Rgba32Float | StorageFormat::Rgba32Uint);
    supported.then_some((*format, *access))
}

fn texture_access(ty: &naga::TypeInner) -> Option<Access> {
    match texture_of(ty)?.1 {
        naga::StorageAccess::LOAD => Some(Access::Read),
        naga::StorageAccess::STORE => Some(Access::Write),
        _ => None,
    }
}
