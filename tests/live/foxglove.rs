//! Foxglove's socket: serves the list of topics to those who ask in its protocol, and nothing to others.

use std::io::{Read, Write};
use std::net::{Ipv4Addr, SocketAddr, TcpStream};
use std::time::{Duration, Instant};

use limpid::live::NodeOptions;

use super::peer::{Node, PATIENCE, domain, no_network, node_options};
use super::robot::{Robot, eye};
use crate::support::gpu::skipped;

/// A client of WebSocket, as far as this needs one.
struct Socket {
    stream: TcpStream,
    waiting: Vec<u8>,
}

impl Socket {
    /// Connects with a subprotocol; the answer's first line.
    fn open(address: SocketAddr, protocol: &str) -> (Self, String) {
        let mut stream = TcpStream::connect(address).unwrap();
        stream.set_read_timeout(Some(Duration::from_secs(20))).unwrap();
        let request = format!(
            "GET / HTTP/1.1\r\nHost: {address}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n\
             Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Protocol: {protocol}\r\n\r\n"
        );
        stream.write_all(request.as_bytes()).unwrap();
        let mut socket = Self { stream, waiting: Vec::new() };
        while !socket.waiting.windows(4).any(|end| end == b"\r\n\r\n") && socket.fill() {}
        let end = socket
            .waiting
            .windows(4)
            .position(|end| end == b"\r\n\r\n")
            .map_or(socket.waiting.len(), |at| at + 4);
        let head: Vec<u8> = socket.waiting.drain(..end).collect();
        let first = String::from_utf8_lossy(&head).lines().next().unwrap_or_default().to_owned();
        (socket, first)
    }

    fn fill(&mut self) -> bool {
        let mut bytes = [0; 65536];
        let count = self.stream.read(&mut bytes).unwrap_or(0);
        self.waiting.extend(&bytes[..count]);
        count > 0
    }

    fn take(&mut self, count: usize) -> Vec<u8> {
        while self.waiting.len() < count {
            assert!(self.fill(), "the socket is closed");
        }
        self.waiting.drain(..count).collect()
    }

    /// The next frame: its kind and its payload.
    fn next(&mut self) -> (u8, Vec<u8>) {
        let head = self.take(2);
        let length = match head[1] & 0x7f {
            126 => u64::from(u16::from_be_bytes(self.take(2).try_into().unwrap())),
            127 => u64::from_be_bytes(self.take(8).try_into().unwrap()),
            short => u64::from(short),
        };
        (head[0] & 0xf, self.take(usize::try_from(length).unwrap()))
    }

    /// Sends a text, masked with zeros.
    fn send(&mut self, text: &str) {
        let length = u8::try_from(text.len()).unwrap();
        assert!(length < 126);
        self.stream.write_all(&[0x81, 0x80 | length, 0, 0, 0, 0]).unwrap();
        self.stream.write_all(text.as_bytes()).unwrap();
    }
}

/// The number of a topic's channel in what is advertised.
fn channel(advertised: &str, topic: &str) -> Option<u64> {
    let advertised: serde_json::Value = serde_json::from_str(advertised).ok()?;
    let channels = advertised["channels"].as_array()?;
    channels.iter().find(|channel| channel["topic"] == topic)?["id"].as_u64()
}

/// Subscribes to a topic once it is advertised: the first message of it.
fn first_message(client: &mut Socket, topic: &str, until: Instant) -> Vec<u8> {
    let number = loop {
        assert!(Instant::now() < until, "{topic} is not advertised");
        let (kind, payload) = client.next();
        let text = String::from_utf8_lossy(&payload).into_owned();
        if let Some(number) = channel(&text, topic).filter(|_| kind == 1) {
            assert!(channel(&text, "/limpid/depth_filtered/image").is_some(), "{text}");
            break number;
        }
    };
    client.send(&format!(r#"{{"op":"subscribe","subscriptions":[{{"id":7,"channelId":{number}}}]}}"#));
    loop {
        assert!(Instant::now() < until, "no message comes");
        let (kind, payload) = client.next();
        if kind == 2 && payload[0] == 1 {
            return payload;
        }
    }
}

#[test]
fn foxglove_is_served_the_map_and_nobody_anything_else() {
    if no_network() || skipped() {
        return;
    }
    let environment = domain();
    let any = SocketAddr::new(Ipv4Addr::LOCALHOST.into(), 0);
    let node = Node::start(&environment, NodeOptions { foxglove: Some(any), ..node_options(eye()) });
    let _robot = Robot::start(&environment, Default::default(), false);
    node.wait_for("maps camera", 1);
    let address: SocketAddr = node.said("Foxglove: open ws://").rsplit('/').next().unwrap().parse().unwrap();
    assert!(address.ip().is_loopback());

    let (mut client, answer) = Socket::open(address, "foxglove.sdk.v1");
    assert!(answer.contains("101"), "{answer}");
    let until = Instant::now() + PATIENCE;
    let message = first_message(&mut client, "/limpid/costmap", until);
    // Kind, number of the subscription, time, CDR: a grid of 60x60 cells.
    assert_eq!(u32::from_le_bytes(message[1..5].try_into().unwrap()), 7);
    assert!(message.len() > 60 * 60 && message[13..15] == [0, 1], "{} bytes", message.len());

    // What is not served is refused: other protocols, and messages from clients.
    let (_, answer) = Socket::open(address, "chat");
    assert!(!answer.contains("101"), "{answer}");
    client.send(
        r#"{"op":"advertise","channels":[{"id":1,"topic":"/cmd_vel","encoding":"json","schemaName":""}]}"#,
    );
    let refused = loop {
        assert!(Instant::now() < until, "it is not refused");
        let (kind, payload) = client.next();
        let text = String::from_utf8_lossy(&payload).into_owned();
        if kind == 1 && text.contains("status") {
            break text;
        }
    };
    assert!(refused.contains("capability") || refused.contains("support"), "{refused}");

    // A port in use is named.
    let taken = NodeOptions { foxglove: Some(address), ..node_options(eye()) };
    let environment = domain();
    let error = limpid::live::run_node(&taken, &environment, &Default::default(), &mut |_| ()).unwrap_err();
    assert!(error.to_string().contains("--foxglove"), "{error}");
    node.end();
}
