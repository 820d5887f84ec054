//! Schemas of the Foxglove messages that limpid writes, as an MCAP holds them: a `google.protobuf.FileDescriptorSet` of a
//! message and of all that it needs.

use prost::Message as _;
use prost_types::field_descriptor_proto::{Label, Type};
use prost_types::{
    DescriptorProto, EnumDescriptorProto, EnumValueDescriptorProto, FieldDescriptorProto,
    FileDescriptorProto, FileDescriptorSet,
};

use crate::message::foxglove::packed_element_field::NumericType;

/// Type of a field, with the name of the message or enumeration that it is.
#[derive(Clone, Copy)]
struct Of(Type, &'static str);

const DOUBLE: Of = Of(Type::Double, "");
const STRING: Of = Of(Type::String, "");
const FIXED32: Of = Of(Type::Fixed32, "");
const BYTES: Of = Of(Type::Bytes, "");
const TIMESTAMP: Of = Of(Type::Message, ".google.protobuf.Timestamp");

const TIMESTAMP_FILE: &str = "google/protobuf/timestamp.proto";

/// The schema of `foxglove.Grid`.
pub(crate) fn grid() -> Vec<u8> {
    let message = |name| Of(Type::Message, name);
    let grid = message_of(
        "Grid",
        vec![
            field(1, "timestamp", TIMESTAMP),
            field(2, "frame_id", STRING),
            field(3, "pose", message(".foxglove.Pose")),
            field(4, "column_count", FIXED32),
            field(5, "cell_size", message(".foxglove.Vector2")),
            field(6, "row_stride", FIXED32),
            field(7, "cell_stride", FIXED32),
            repeated(8, "fields", message(".foxglove.PackedElementField")),
            field(9, "data", BYTES),
        ],
    );
    let needed = ["PackedElementField", "Pose", "Vector2"].map(|name| format!("foxglove/{name}.proto"));
    let needed = needed.into_iter().chain([TIMESTAMP_FILE.to_owned()]).collect();
    let file = vec![timestamp_file(), vector2(), vector3(), quaternion(), pose(), packed_element_field()];
    let file = file.into_iter().chain([file_of(grid, needed)]).collect();
    FileDescriptorSet { file }.encode_to_vec()
}

fn timestamp_file() -> FileDescriptorProto {
    let fields = vec![field(1, "seconds", Of(Type::Int64, "")), field(2, "nanos", Of(Type::Int32, ""))];
    FileDescriptorProto {
        name: Some(TIMESTAMP_FILE.into()),
        package: Some("google.protobuf".into()),
        ..file_of(message_of("Timestamp", fields), Vec::new())
    }
}

fn vector2() -> FileDescriptorProto {
    file_of(message_of("Vector2", doubles(&["x", "y"])), Vec::new())
}

fn vector3() -> FileDescriptorProto {
    file_of(message_of("Vector3", doubles(&["x", "y", "z"])), Vec::new())
}

fn quaternion() -> FileDescriptorProto {
    file_of(message_of("Quaternion", doubles(&["x", "y", "z", "w"])), Vec::new())
}

fn pose() -> FileDescriptorProto {
    let fields = vec![
        field(1, "position", Of(Type::Message, ".foxglove.Vector3")),
        field(2, "orientation", Of(Type::Message, ".foxglove.Quaternion")),
    ];
    let needed = vec!["foxglove/Quaternion.proto".into(), "foxglove/Vector3.proto".into()];
    file_of(message_of("Pose", fields), needed)
}

fn packed_element_field() -> FileDescriptorProto {
    let values = [
        ("UNKNOWN", NumericType::Unknown),
        ("UINT8", NumericType::Uint8),
        ("INT8", NumericType::Int8),
        ("UINT16", NumericType::Uint16),
        ("INT16", NumericType::Int16),
        ("UINT32", NumericType::Uint32),
        ("INT32", NumericType::Int32),
        ("FLOAT32", NumericType::Float32),
        ("FLOAT64", NumericType::Float64),
    ];
    let value = |(name, number): (&str, NumericType)| EnumValueDescriptorProto {
        name: Some(name.into()),
        number: Some(number as i32),
        options: None,
    };
    let numeric_type = EnumDescriptorProto {
        name: Some("NumericType".into()),
        value: values.into_iter().map(value).collect(),
        ..EnumDescriptorProto::default()
    };
    let numeric = Of(Type::Enum, ".foxglove.PackedElementField.NumericType");
    let fields = vec![field(1, "name", STRING), field(2, "offset", FIXED32), field(3, "type", numeric)];
    let message = message_of("PackedElementField", fields);
    file_of(DescriptorProto { enum_type: vec![numeric_type], ..message }, Vec::new())
}

/// `foxglove/<message>.proto`.
fn file_of(message: DescriptorProto, needed: Vec<String>) -> FileDescriptorProto {
    FileDescriptorProto {
        name: Some(format!("foxglove/{}.proto", message.name())),
        package: Some("foxglove".into()),
        dependency: needed,
        message_type: vec![message],
        syntax: Some("proto3".into()),
        ..FileDescriptorProto::default()
    }
}

fn message_of(name: &str, field: Vec<FieldDescriptorProto>) -> DescriptorProto {
    DescriptorProto { name: Some(name.into()), field, ..DescriptorProto::default() }
}

/// Fields numbered from 1.
fn doubles(names: &[&str]) -> Vec<FieldDescriptorProto> {
    (1..).zip(names).map(|(number, name)| field(number, name, DOUBLE)).collect()
}

fn field(number: i32, name: &str, Of(kind, type_name): Of) -> FieldDescriptorProto {
    FieldDescriptorProto {
        name: Some(name.into()),
        number: Some(number),
        label: Some(Label::Optional as i32),
        r#type: Some(kind as i32),
        type_name: (!type_name.is_empty()).then(|| type_name.into()),
        ..FieldDescriptorProto::default()
    }
}

fn repeated(number: i32, name: &str, of: Of) -> FieldDescriptorProto {
    FieldDescriptorProto { label: Some(Label::Repeated as i32), ..field(number, name, of) }
}
