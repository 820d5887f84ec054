//! What was received and waits to be read: bounded, the oldest of a topic goes first where too much waits.

use std::collections::VecDeque;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::task::{Wake, Waker};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use crate::base::{Error, Result};
use crate::ros2::participant::{Subscription, Taken};
use crate::ros2::service::Origin;

/// A message as it came.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Parcel {
    /// The number that its topic was added with.
    pub topic: u32,
    /// Who sent it, under which number.
    pub origin: Origin,
    /// When it came.
    pub arrived: Instant,
    /// Encapsulation and CDR.
    pub payload: Vec<u8>,
}

/// What happened to the messages of a topic so far.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Counts {
    /// Received.
    pub received: u64,
    /// Lost on the way, as the numbers of their writers tell.
    pub lost: u64,
    /// Not CDR.
    pub malformed: u64,
    /// Dropped here, since newer ones came before they could be read.
    pub dropped: u64,
}

#[derive(Debug, Clone, Copy, Default)]
struct Shelf {
    most: usize,
    /// Whether a message is worth nothing once a newer one is there and it has waited long.
    perishable: bool,
    waiting: usize,
    counts: Counts,
}

/// Messages of all topics in order of arrival.
#[derive(Debug, Default)]
struct Queue {
    shelves: Vec<(u32, Shelf)>,
    waiting: VecDeque<Parcel>,
}

impl Queue {
    fn shelf(&mut self, topic: u32) -> Option<&mut Shelf> {
        self.shelves.iter_mut().find(|(number, _)| *number == topic).map(|(_, shelf)| shelf)
    }

    fn put(&mut self, parcel: Parcel) {
        let topic = parcel.topic;
        let Some(shelf) = self.shelf(topic) else { return };
        shelf.counts.received += 1;
        shelf.waiting += 1;
        let full = shelf.waiting > shelf.most;
        if full {
            shelf.waiting -= 1;
            shelf.counts.dropped += 1;
        }
        if full && let Some(oldest) = self.waiting.iter().position(|waiting| waiting.topic == topic) {
            self.waiting.remove(oldest);
        }
        self.waiting.push_back(parcel);
    }

    /// The oldest message; a perishable one that came longer than `at_most` ago is dropped where a newer one of its topic
    /// waits.
    fn take(&mut self, now: Instant, at_most: Option<Duration>) -> Option<Parcel> {
        loop {
            let parcel = self.waiting.pop_front()?;
            let Some(shelf) = self.shelf(parcel.topic) else { continue };
            shelf.waiting -= 1;
            let late = at_most.is_some_and(|at_most| now.saturating_duration_since(parcel.arrived) > at_most);
            if !(late && shelf.perishable && shelf.waiting > 0) {
                return Some(parcel);
            }
            shelf.counts.dropped += 1;
        }
    }
}

/// Wakes the thread that receives.
#[derive(Debug, Default)]
struct Bell {
    rung: Mutex<Rung>,
    heard: Condvar,
}

#[derive(Debug, Clone, Copy, Default)]
struct Rung {
    data: bool,
    stop: bool,
}

impl Wake for Bell {
    fn wake(self: Arc<Self>) {
        locked(&self.rung).data = true;
        self.heard.notify_all();
    }
}

/// A panic elsewhere leaves nothing half done here.
fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// What the receiving thread and the reader share.
#[derive(Default)]
struct Shared {
    queue: Mutex<Queue>,
    filled: Condvar,
    bell: Arc<Bell>,
    subscriptions: Mutex<Vec<(u32, Subscription)>>,
}

impl Shared {
    /// Moves what has come into the queue, again and again.
    fn receive(&self) {
        let waker = Waker::from(Arc::clone(&self.bell));
        loop {
            for (topic, subscription) in locked(&self.subscriptions).iter_mut() {
                let taken = subscription.drain(&waker, &mut |origin, payload| {
                    let arrived = Instant::now();
                    locked(&self.queue).put(Parcel { topic: *topic, origin, arrived, payload });
                    self.filled.notify_all();
                });
                self.count(*topic, taken);
            }
            let mut rung = locked(&self.bell.rung);
            while !rung.data && !rung.stop {
                rung = self.bell.heard.wait(rung).unwrap_or_else(PoisonError::into_inner);
            }
            if rung.stop {
                return;
            }
            rung.data = false;
        }
    }

    fn count(&self, topic: u32, taken: Taken) {
        if let Some(shelf) = locked(&self.queue).shelf(topic) {
            shelf.counts.lost += taken.lost;
            shelf.counts.malformed += taken.malformed;
        }
    }
}

/// See the module. A thread of its own receives.
pub struct Inbox {
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
}

impl Inbox {
    /// An inbox without topics.
    ///
    /// # Errors
    /// [`Error::Ros2`] where the system starts no thread.
    pub fn open() -> Result<Self> {
        let shared = Arc::new(Shared::default());
        let own = Arc::clone(&shared);
        let thread = thread::Builder::new().name("limpid-receive".into()).spawn(move || own.receive());
        let failed =
            |error: std::io::Error| Error::Ros2 { what: "receiving".into(), reason: error.to_string() };
        Ok(Self { shared, thread: Some(thread.map_err(failed)?) })
    }

    /// Receives from a subscription under a number; at most `most` messages of it wait. `perishable`: a message is worth
    /// nothing once a newer one is there and it has waited long, as with images and unlike with transforms.
    pub fn add(&self, topic: u32, subscription: Subscription, most: usize, perishable: bool) {
        let shelf = Shelf { most: most.max(1), perishable, ..Shelf::default() };
        locked(&self.shared.queue).shelves.push((topic, shelf));
        locked(&self.shared.subscriptions).push((topic, subscription));
        Arc::clone(&self.shared.bell).wake();
    }

    /// Receives no more from a topic; what waits of it is left out.
    pub fn remove(&self, topic: u32) {
        locked(&self.shared.subscriptions).retain(|(number, _)| *number != topic);
        let mut queue = locked(&self.shared.queue);
        queue.shelves.retain(|(number, _)| *number != topic);
        queue.waiting.retain(|parcel| parcel.topic != topic);
    }

    /// The oldest message; a perishable one that came longer than `at_most` ago is dropped where a newer one of its topic
    /// waits.
    pub fn take(&self, at_most: Option<Duration>) -> Option<Parcel> {
        locked(&self.shared.queue).take(Instant::now(), at_most)
    }

    /// When the oldest message that waits came.
    pub fn oldest(&self) -> Option<Instant> {
        locked(&self.shared.queue).waiting.front().map(|parcel| parcel.arrived)
    }

    /// Waits until a message is there, or until `until`; whether one is.
    pub fn wait(&self, until: Instant) -> bool {
        let mut queue = locked(&self.shared.queue);
        while queue.waiting.is_empty() {
            let left = until.saturating_duration_since(Instant::now());
            if left.is_zero() {
                return false;
            }
            queue = match self.shared.filled.wait_timeout(queue, left) {
                Ok((queue, _)) => queue,
                Err(poisoned) => poisoned.into_inner().0,
            };
        }
        true
    }

    /// What happened to the messages of a topic so far.
    pub fn counts(&self, topic: u32) -> Counts {
        locked(&self.shared.queue).shelf(topic).map(|shelf| shelf.counts).unwrap_or_default()
    }
}

impl Drop for Inbox {
    fn drop(&mut self) {
        locked(&self.shared.bell.rung).stop = true;
        self.shared.bell.heard.notify_all();
        if let Some(thread) = self.thread.take() {
            // It has nothing to say.
            let _ = thread.join();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn queue(most: &[usize]) -> Queue {
        let shelf = |(number, &most): (u32, &usize)| {
            (number, Shelf { most, perishable: number == 0, ..Shelf::default() })
        };
        Queue { shelves: (0..).zip(most).map(shelf).collect(), waiting: VecDeque::new() }
    }

    fn parcel(topic: u32, arrived: Instant, number: u8) -> Parcel {
        Parcel { topic, origin: Origin::default(), arrived, payload: vec![number] }
    }

    #[test]
    fn the_oldest_of_the_same_topic_goes_first_and_is_counted() {
        let (mut queue, now) = (queue(&[2, 9]), Instant::now());
        for (topic, number) in [(0, 1), (1, 2), (0, 3), (0, 4), (1, 5)] {
            queue.put(parcel(topic, now, number));
        }
        let taken: Vec<u8> =
            std::iter::from_fn(|| queue.take(now, None)).map(|parcel| parcel.payload[0]).collect();
        assert_eq!(taken, [2, 3, 4, 5]);
        let counts = |queue: &mut Queue, topic| queue.shelf(topic).unwrap().counts;
        assert_eq!(counts(&mut queue, 0), Counts { received: 3, dropped: 1, ..Counts::default() });
        assert_eq!(counts(&mut queue, 1).dropped, 0);
    }

    #[test]
    fn what_waited_too_long_is_dropped_only_for_something_newer() {
        let (mut queue, start) = (queue(&[9]), Instant::now());
        let later = |ms| start + Duration::from_millis(ms);
        for (ms, number) in [(0, 1), (10, 2), (190, 3)] {
            queue.put(parcel(0, later(ms), number));
        }
        let most = Some(Duration::from_millis(100));
        assert_eq!(queue.take(later(200), most).unwrap().payload, [3]);
        assert_eq!(queue.shelf(0).unwrap().counts.dropped, 2);
        queue.put(parcel(0, later(200), 4));
        assert_eq!(
            queue.take(later(900), most).unwrap().payload,
            [4],
            "the newest is kept however old it is"
        );
        assert!(queue.take(later(900), most).is_none());
        // What does not perish waits for as long as it takes.
        let mut queue = self::queue(&[9, 9]);
        queue.put(parcel(1, later(0), 5));
        queue.put(parcel(1, later(1), 6));
        assert_eq!(queue.take(later(900), most).unwrap().payload, [5]);
    }

    #[test]
    fn messages_of_a_topic_that_is_not_there_are_left_out() {
        let mut queue = queue(&[1]);
        queue.put(parcel(7, Instant::now(), 1));
        assert!(queue.take(Instant::now(), None).is_none());
    }
}
