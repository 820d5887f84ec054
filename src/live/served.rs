//! The list of topics for Foxglove, over WebSocket: what nobody has subscribed to is not made, and nothing is taken from clients.

use std::collections::HashMap;
use std::net::SocketAddr;
use std::sync::Arc;

use foxglove::{
    ChannelBuilder, Context, FoxgloveError, PartialMetadata, RawChannel, Schema, WebSocketServer,
    WebSocketServerHandle,
};

use crate::base::{Error, Result};
use crate::message::ros2::{TFMessage, encode_cdr};
use crate::message::written::DiagnosticArray;
use crate::message::{RosMessage, schema};
use crate::output::topics::TopicSink;
use crate::ros2::Naming;

/// Topics that are not under the node's own name.
pub(super) const DIAGNOSTICS: &str = "/diagnostics";
pub(super) const TRANSFORMS: &str = "/tf";

/// Messages that wait for a client that reads slowly; then the oldest go.
const WAITING: usize = 16;

/// See the module. Dropping it closes the socket.
pub(super) struct Served<'a> {
    naming: &'a Naming,
    context: Arc<Context>,
    server: Option<WebSocketServerHandle>,
    /// By the name in the list.
    channels: HashMap<String, Arc<RawChannel>>,
}

fn failed(what: &str, error: &FoxgloveError) -> Error {
    Error::Ros2 { what: what.into(), reason: error.to_string() }
}

impl<'a> Served<'a> {
    /// Listens at an address.
    ///
    /// # Errors
    /// [`Error::Config`] where the address cannot be had, as when its port is in use.
    pub(super) fn open(address: SocketAddr, naming: &'a Naming) -> Result<Self> {
        let context = Context::new();
        let server = WebSocketServer::new()
            .name("limpid")
            .bind(address.ip().to_string(), address.port())
            .context(&context)
            .message_backlog_size(WAITING)
            .capabilities([])
            .start_blocking();
        let server = server.map_err(|error| Error::Config {
            key: "--foxglove".into(),
            reason: format!("{address} cannot be listened at: {error}"),
        })?;
        let mut served = Self { naming, context, server: Some(server), channels: HashMap::new() };
        served.offer(DIAGNOSTICS, DiagnosticArray::TYPE)?;
        served.offer(TRANSFORMS, TFMessage::TYPE)?;
        Ok(served)
    }

    /// The port that it listens at.
    pub(super) fn port(&self) -> u16 {
        self.server.as_ref().map_or(0, WebSocketServerHandle::port)
    }

    fn offer(&mut self, topic: &str, type_name: &'static str) -> Result<()> {
        if self.channels.contains_key(topic) {
            return Ok(());
        }
        let name = if topic.starts_with('/') { topic.to_owned() } else { format!("~/{topic}") };
        let text =
            schema::full_text(type_name).map_err(|reason| Error::Ros2 { what: topic.into(), reason })?;
        let channel = ChannelBuilder::new(self.naming.resolve(&name)?)
            .message_encoding("cdr")
            .schema(Schema::new(type_name, "ros2msg", text.into_bytes()))
            .context(&self.context)
            .build_raw();
        let channel = channel.map_err(|error| failed(topic, &error))?;
        self.channels.insert(topic.into(), channel);
        Ok(())
    }

    /// Has the topics of the list, and those alone beside its own.
    ///
    /// # Errors
    /// [`Error::Ros2`].
    pub(super) fn offer_list(&mut self, topics: &[(String, &'static str)]) -> Result<()> {
        self.channels.retain(|name, channel| {
            let kept = name.starts_with('/') || topics.iter().any(|(topic, _)| topic == name);
            if !kept {
                channel.close();
            }
            kept
        });
        topics.iter().try_for_each(|(name, kind)| self.offer(name, kind))
    }
}

impl Drop for Served<'_> {
    fn drop(&mut self) {
        if let Some(server) = self.server.take() {
            // What clients miss when this ends is their own affair.
            drop(server.stop());
        }
    }
}

impl TopicSink for Served<'_> {
    fn wants(&self, topic: &str) -> bool {
        self.channels.get(topic).is_some_and(|channel| channel.has_sinks())
    }

    fn put<M: RosMessage>(&mut self, topic: &str, stamp_ns: u64, message: &M) -> Result<()> {
        if let Some(channel) = self.channels.get(topic).filter(|channel| channel.has_sinks()) {
            channel
                .log_with_meta(&encode_cdr(M::TYPE, message)?, PartialMetadata { log_time: Some(stamp_ns) });
        }
        Ok(())
    }

    fn error(&self, reason: String) -> Error {
        Error::Ros2 { what: "a result".into(), reason }
    }
}
