//! The node's services: clearing and saving its map, and its parameters.

use std::net::SocketAddr;
use std::path::Path;

use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::base::Result;
use crate::live::node::Node;
use crate::live::parameters;
use crate::message::ros2::{Time, decode_cdr, encode_cdr};
use crate::message::service::{
    DescribeParametersReply, GetParameterTypesReply, GetParametersReply, NamesRequest, Parameter,
    ParameterEvent, SaveMapReply, SaveMapRequest, SetParametersReply, SetParametersRequest, SetResult,
    TriggerReply,
};
use crate::ros2::{Asker, Inbox, Naming, Parcel, Participant, Replies};

/// A service.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Clear,
    SaveMap,
    List,
    Get,
    Types,
    Describe,
    Set,
    SetAll,
}

/// Services by name and type.
const SERVICES: [(Kind, &str, &str); 8] = [
    (Kind::Clear, "~/clear", "std_srvs/srv/Trigger"),
    (Kind::SaveMap, "~/save_map", "nav2_msgs/srv/SaveMap"),
    (Kind::List, "~/list_parameters", "rcl_interfaces/srv/ListParameters"),
    (Kind::Get, "~/get_parameters", "rcl_interfaces/srv/GetParameters"),
    (Kind::Types, "~/get_parameter_types", "rcl_interfaces/srv/GetParameterTypes"),
    (Kind::Describe, "~/describe_parameters", "rcl_interfaces/srv/DescribeParameters"),
    (Kind::Set, "~/set_parameters", "rcl_interfaces/srv/SetParameters"),
    (Kind::SetAll, "~/set_parameters_atomically", "rcl_interfaces/srv/SetParametersAtomically"),
];

/// Number under which the first service's requests are received; topics that are read have small ones.
const FIRST: u32 = u32::MAX - 64;

/// Requests of a service that wait at most.
const WAITING: usize = 64;

/// See the module.
pub(super) struct Services {
    replies: Vec<Replies>,
    /// Identities of the readers.
    pub(super) readers: Vec<[u8; 16]>,
    /// Requests that were not understood.
    pub(super) malformed: u64,
}

impl Services {
    /// Offers all services.
    ///
    /// # Errors
    /// [`crate::Error::Ros2`].
    pub(super) fn open(participant: &Participant, naming: &Naming, inbox: &Inbox) -> Result<Self> {
        let mut services = Self { replies: Vec::new(), readers: Vec::new(), malformed: 0 };
        for (number, (_, name, type_name)) in (FIRST..).zip(SERVICES) {
            let (requests, replies) = participant.serve(&naming.resolve(name)?, type_name)?;
            services.readers.push(requests.guid());
            services.replies.push(replies);
            inbox.add(number, requests, WAITING, false);
        }
        Ok(services)
    }

    /// Identities of the writers.
    pub(super) fn writers(&self) -> impl Iterator<Item = [u8; 16]> {
        self.replies.iter().map(Replies::guid)
    }

    /// Whether messages of that number are requests.
    pub(super) fn has(number: u32) -> bool {
        number.checked_sub(FIRST).is_some_and(|at| (at as usize) < SERVICES.len())
    }
}

impl Node<'_> {
    /// Tells Foxglove too, at an address.
    ///
    /// # Errors
    /// [`crate::Error::Config`] where it cannot be listened at.
    #[cfg(feature = "foxglove")]
    pub(super) fn serve_foxglove(&mut self, address: SocketAddr, say: &mut dyn FnMut(&str)) -> Result<()> {
        let port = self.publisher.serve(address, &self.options.naming)?;
        say(&format!("Foxglove: open ws://{}", SocketAddr::new(address.ip(), port)));
        Ok(())
    }

    /// Refuses: that is not built in.
    ///
    /// # Errors
    /// [`crate::Error::Config`].
    #[cfg(not(feature = "foxglove"))]
    pub(super) fn serve_foxglove(&mut self, _: SocketAddr, _: &mut dyn FnMut(&str)) -> Result<()> {
        let reason = "is not built in: `cargo build --release --features foxglove`".into();
        Err(crate::base::Error::Config { key: "--foxglove".into(), reason })
    }

    /// Answers a request; one that is not understood is counted and not answered.
    ///
    /// # Errors
    /// [`crate::Error::Ros2`].
    pub(super) fn serve(&mut self, parcel: &Parcel, say: &mut dyn FnMut(&str)) -> Result<()> {
        let at = parcel.topic.wrapping_sub(FIRST) as usize;
        let Some(&(kind, name, _)) = SERVICES.get(at) else { return Ok(()) };
        let reply = Asker::of(parcel.origin, &parcel.payload)
            .and_then(|(asker, request)| Ok((asker, self.answer(kind, &request, say)?)));
        match (reply, self.services.replies.get(at)) {
            (Ok((asker, reply)), Some(replies)) => replies.send(&asker, &reply),
            (Err(error), _) => {
                self.services.malformed += 1;
                if self.services.malformed == 1 {
                    say(&format!("{name}: a request was not understood: {error}"));
                }
                Ok(())
            }
            (Ok(_), None) => Ok(()),
        }
    }

    fn answer(&mut self, kind: Kind, request: &[u8], say: &mut dyn FnMut(&str)) -> Result<Vec<u8>> {
        match kind {
            // Its request is empty.
            Kind::Clear => encode(&self.clear(say)?),
            Kind::SaveMap => encode(&self.save_map(&decode(request)?, say)),
            Kind::List => encode(&parameters::list(&self.config, &decode(request)?)),
            Kind::Get => {
                let NamesRequest { names } = decode(request)?;
                encode(&GetParametersReply { values: parameters::get(&self.config, &names) })
            }
            Kind::Types => {
                let NamesRequest { names } = decode(request)?;
                let types = parameters::get(&self.config, &names).iter().map(|value| value.kind).collect();
                encode(&GetParameterTypesReply { types })
            }
            Kind::Describe => {
                let NamesRequest { names } = decode(request)?;
                encode(&DescribeParametersReply { descriptors: parameters::describe(&self.config, &names) })
            }
            Kind::Set => {
                let SetParametersRequest { parameters } = decode(request)?;
                encode(&SetParametersReply { results: self.set(&parameters)? })
            }
            Kind::SetAll => {
                let SetParametersRequest { parameters } = decode(request)?;
                encode(&self.set_all(&parameters)?)
            }
        }
    }

    fn clear(&mut self, say: &mut dyn FnMut(&str)) -> Result<TriggerReply> {
        self.begin_anew("~/clear was called", say);
        self.publisher.forget_all()?;
        Ok(TriggerReply { success: true, message: "the map begins anew".into() })
    }

    fn save_map(&mut self, asked: &SaveMapRequest, say: &mut dyn FnMut(&str)) -> SaveMapReply {
        let saved = self.publisher.can_save(asked).and_then(|()| {
            let saved = self.publisher.save_map(Path::new(&asked.map_url));
            saved.map_err(|error| error.to_string())
        });
        match &saved {
            Ok(path) => say(&format!("~/save_map: saved as {}", path.display())),
            Err(reason) => say(&format!("~/save_map: not saved: {reason}")),
        }
        SaveMapReply { result: saved.is_ok() }
    }

    /// Sets parameters one by one.
    fn set(&mut self, asked: &[Parameter]) -> Result<Vec<SetResult>> {
        let mut changed = self.config.clone();
        let results: Vec<_> =
            asked.iter().map(|parameter| parameters::set(&mut changed, parameter)).collect();
        self.change(changed)?;
        Ok(results)
    }

    /// Sets all parameters or none.
    fn set_all(&mut self, asked: &[Parameter]) -> Result<SetResult> {
        let mut changed = self.config.clone();
        let mut results = asked.iter().map(|parameter| parameters::set(&mut changed, parameter));
        if let Some(refused) = results.find(|result| !result.successful) {
            return Ok(refused);
        }
        self.change(changed)?;
        Ok(SetResult { successful: true, reason: String::new() })
    }

    /// Goes on with other parameters, and tells which they are.
    fn change(&mut self, config: crate::config::Config) -> Result<()> {
        let before = std::mem::replace(&mut self.config, config);
        if let Some(reading) = &mut self.reading {
            reading.source.set_patience(&self.config);
        }
        if let Some(mapping) = &mut self.mapping {
            mapping.set_rhythm(&self.config);
        }
        self.publisher.set_parameters(&self.config);
        let pairs = before.listed().into_iter().zip(self.config.listed());
        let changed = pairs.filter(|(before, now)| before != now).map(|(_, (name, _))| name);
        let changed: Vec<String> = changed.collect();
        if changed.is_empty() {
            return Ok(());
        }
        let values = parameters::get(&self.config, &changed);
        let event = ParameterEvent {
            stamp: Time::from_stamp_ns(self.time.stamp_ns()),
            node: self.options.naming.full_name(),
            changed_parameters: changed
                .into_iter()
                .zip(values)
                .map(|(name, value)| Parameter { name, value })
                .collect(),
            ..ParameterEvent::default()
        };
        self.publisher.tell_parameters(&event)
    }
}

fn decode<T: DeserializeOwned>(request: &[u8]) -> Result<T> {
    decode_cdr("request", request)
}

fn encode<T: Serialize>(reply: &T) -> Result<Vec<u8>> {
    encode_cdr("reply", reply)
}
