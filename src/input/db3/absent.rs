//! Stands in where limpid is built without SQLite.

use std::convert::Infallible;
use std::path::Path;

use crate::base::{Error, Result};
use crate::input::log::{Record, Records};

fn refused<T>(path: &Path) -> Result<T> {
    let reason = "is an SQLite bag (.db3), and limpid is built without its feature `db3`: convert it with `ros2 bag convert`";
    Err(Error::Format { path: path.into(), reason: reason.into() })
}

/// Never made.
pub(in crate::input) struct Db3Records(Infallible);

impl Records for Db3Records {
    fn open(path: &Path) -> Result<Self> {
        refused(path)
    }

    fn summary(path: &Path) -> Result<Vec<Record>> {
        refused(path)
    }

    fn next_in_chunk(&mut self, _: &dyn Fn(u32) -> bool) -> Option<Record> {
        match self.0 {}
    }

    fn next_in_file(&mut self, _: &dyn Fn(u32) -> bool) -> Result<Option<Record>> {
        match self.0 {}
    }

    fn ended(&self) -> bool {
        match self.0 {}
    }

    fn offset(&self) -> u64 {
        match self.0 {}
    }

    fn take_notes(&mut self) -> Vec<String> {
        match self.0 {}
    }
}

/// Never made.
#[derive(Debug)]
pub(in crate::input) struct Unpacked(Infallible);

impl Unpacked {
    pub(in crate::input) fn of(path: &Path) -> Result<Self> {
        refused(path)
    }

    pub(in crate::input) fn path(&self) -> &Path {
        match self.0 {}
    }
}
