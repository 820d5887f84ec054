//! Requests and replies of ROS 2 services that a node has; fields in the order of their definitions.

use serde::{Deserialize, Serialize};

use crate::message::RosMessage;
use crate::message::ros2::Time;

/// Reply of `std_srvs/Trigger`.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct TriggerReply {
    /// Whether it was done.
    pub success: bool,
    /// In words.
    pub message: String,
}

/// Request of `nav2_msgs/SaveMap`.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct SaveMapRequest {
    /// Topic of the map; empty: the costmap.
    pub map_topic: String,
    /// Path without an extension.
    pub map_url: String,
    /// `pgm`; empty: the same.
    pub image_format: String,
    /// `trinary`; empty: the same.
    pub map_mode: String,
    /// Occupancy up to which a cell is free; limpid knows that without.
    pub free_thresh: f32,
    /// Occupancy from which a cell is occupied; limpid knows that without.
    pub occupied_thresh: f32,
}

/// Reply of `nav2_msgs/SaveMap`.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct SaveMapReply {
    /// Whether it was saved.
    pub result: bool,
}

/// `rcl_interfaces/ParameterValue`: the one field that `kind` names holds the value.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct ParameterValue {
    /// One of [`ParameterKind`] as its number.
    pub kind: u8,
    /// Of kind 1.
    pub bool_value: bool,
    /// Of kind 2.
    pub integer_value: i64,
    /// Of kind 3.
    pub double_value: f64,
    /// Of kind 4.
    pub string_value: String,
    /// Of kind 5.
    pub byte_array_value: Vec<u8>,
    /// Of kind 6.
    pub bool_array_value: Vec<bool>,
    /// Of kind 7.
    pub integer_array_value: Vec<i64>,
    /// Of kind 8.
    pub double_array_value: Vec<f64>,
    /// Of kind 9.
    pub string_array_value: Vec<String>,
}

/// Kinds of [`ParameterValue`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ParameterKind {
    /// There is no value.
    NotSet = 0,
    /// A truth value.
    Bool = 1,
    /// A whole number.
    Integer = 2,
    /// A number.
    Double = 3,
    /// A text.
    Text = 4,
    /// Truth values.
    Bools = 6,
    /// Whole numbers.
    Integers = 7,
    /// Numbers.
    Doubles = 8,
    /// Texts.
    Texts = 9,
}

/// `rcl_interfaces/Parameter`.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Parameter {
    /// Name.
    pub name: String,
    /// Value.
    pub value: ParameterValue,
}

/// Request of `rcl_interfaces/ListParameters`.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct ListParametersRequest {
    /// Names of sections whose parameters are asked for; none: all.
    pub prefixes: Vec<String>,
    /// How many parts a name has at most after its prefix; 0: any number.
    pub depth: u64,
}

/// Reply of `rcl_interfaces/ListParameters`.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct ListParametersReply {
    /// Names.
    pub names: Vec<String>,
    /// Sections that these are in.
    pub prefixes: Vec<String>,
}

/// Request of `rcl_interfaces/GetParameters`, `GetParameterTypes` and `DescribeParameters`.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct NamesRequest {
    /// Names.
    pub names: Vec<String>,
}

/// Reply of `rcl_interfaces/GetParameters`.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct GetParametersReply {
    /// Values in the order of the names that were asked for.
    pub values: Vec<ParameterValue>,
}

/// Reply of `rcl_interfaces/GetParameterTypes`.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct GetParameterTypesReply {
    /// [`ParameterKind`] of each name that was asked for, as its number.
    pub types: Vec<u8>,
}

/// `rcl_interfaces/ParameterDescriptor`.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct ParameterDescriptor {
    /// Name.
    pub name: String,
    /// [`ParameterKind`] as its number.
    pub kind: u8,
    /// In words.
    pub description: String,
    /// In words.
    pub additional_constraints: String,
    /// Whether it cannot be changed while the node runs.
    pub read_only: bool,
    /// Whether its kind may change.
    pub dynamic_typing: bool,
    /// From, to and step; at most one.
    pub floating_point_range: Vec<[f64; 3]>,
    /// From, to and step; at most one.
    pub integer_range: Vec<(i64, i64, u64)>,
}

/// Reply of `rcl_interfaces/DescribeParameters`.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct DescribeParametersReply {
    /// In the order of the names that were asked for.
    pub descriptors: Vec<ParameterDescriptor>,
}

/// Request of `rcl_interfaces/SetParameters` and `SetParametersAtomically`.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct SetParametersRequest {
    /// What to set.
    pub parameters: Vec<Parameter>,
}

/// `rcl_interfaces/SetParametersResult`, which is the reply of `SetParametersAtomically` too.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct SetResult {
    /// Whether it was set.
    pub successful: bool,
    /// Why not.
    pub reason: String,
}

/// Reply of `rcl_interfaces/SetParameters`.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct SetParametersReply {
    /// In the order of the parameters.
    pub results: Vec<SetResult>,
}

/// `rcl_interfaces/ParameterEvent`.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct ParameterEvent {
    /// When.
    pub stamp: Time,
    /// Full name of the node.
    pub node: String,
    /// Parameters that there were not before.
    pub new_parameters: Vec<Parameter>,
    /// Parameters that have another value.
    pub changed_parameters: Vec<Parameter>,
    /// Parameters that are no more.
    pub deleted_parameters: Vec<Parameter>,
}

impl RosMessage for ParameterEvent {
    const TYPE: &'static str = "rcl_interfaces/msg/ParameterEvent";
}
