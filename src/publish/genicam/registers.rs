//! The registers that can be written, by address, with what may be written into them.

use std::collections::BTreeMap;

use super::address as at;
use super::feature::{Access, Feature, Kind};
use crate::publish::gvcp::Status;

/// What a register takes.
#[derive(Clone, Debug, PartialEq)]
enum Check {
    /// 32 bits between two values.
    Range(u32, u32),
    /// One of these values.
    OneOf(Vec<u32>),
    /// An f64 between two values.
    Float(f64, f64),
    /// Text up to the length of the register.
    Text,
    /// Nothing: clients read it.
    Nothing,
}

/// A register.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Register {
    /// Its address.
    pub address: u32,
    /// Its bytes.
    pub bytes: u32,
    /// Whether it is written only while no frame is acquired.
    pub at_rest: bool,
    check: Check,
}

impl Register {
    fn of(feature: &Feature) -> Option<Self> {
        let check = match &feature.kind {
            _ if feature.access == Access::Read => Check::Nothing,
            Kind::Integer(least, largest) => Check::Range(*least, largest.fixed()),
            Kind::Float(least, largest, _) => Check::Float(*least, *largest),
            Kind::Choice(entries) => Check::OneOf(entries.iter().map(|(_, value)| *value).collect()),
            Kind::Flag => Check::Range(0, 1),
            Kind::Command(value) => Check::OneOf(vec![0, *value]),
            Kind::Text(_) => Check::Text,
            Kind::Long => Check::Nothing,
            Kind::Bits(..) | Kind::Bit(_) | Kind::Switch(_) => return None,
        };
        let at_rest = feature.access == Access::WriteAtRest;
        Some(Self { address: feature.address, bytes: feature.kind.bytes(), at_rest, check })
    }

    /// Whether these bytes may be written.
    ///
    /// # Errors
    /// The status that answers the write: a register for reading, a value out of its range, bytes
    /// of another length.
    pub(crate) fn accepts(&self, bytes: &[u8]) -> Result<(), Status> {
        if self.check == Check::Nothing {
            return Err(Status::WriteProtect);
        }
        let word = || bytes.try_into().map(u32::from_be_bytes).map_err(|_| Status::InvalidAddress);
        let fits = match &self.check {
            Check::Range(least, largest) => (*least..=*largest).contains(&word()?),
            Check::OneOf(values) => values.contains(&word()?),
            Check::Float(least, largest) => {
                let value = bytes.try_into().map(f64::from_be_bytes).map_err(|_| Status::InvalidAddress)?;
                (*least..=*largest).contains(&value)
            }
            Check::Text => bytes.len() <= self.bytes as usize,
            Check::Nothing => false,
        };
        if fits { Ok(()) } else { Err(Status::InvalidParameter) }
    }

    fn is_text(&self) -> bool {
        self.check == Check::Text
    }
}

/// All registers of a head by their addresses.
#[derive(Clone, Debug)]
pub(crate) struct RegisterMap(BTreeMap<u32, Register>);

impl RegisterMap {
    /// The registers of the features, and those whose bits are features of their own.
    pub(crate) fn new(features: &[Feature]) -> Self {
        let whole =
            |address, at_rest| Register { address, bytes: 4, at_rest, check: Check::Range(0, u32::MAX) };
        let mut all: BTreeMap<u32, Register> = [
            (at::PACKET_SIZE, true),
            (at::GVSP_CONFIGURATION, true),
            (at::GVCP_CONFIGURATION, false),
            (at::STREAM_PORT, false),
        ]
        .map(|(address, at_rest)| (address, whole(address, at_rest)))
        .into();
        for feature in features {
            let Some(register) = Register::of(feature) else { continue };
            let (stride, count) = feature.selected.map_or((0, 1), |s| (s.stride, s.count));
            for k in 0..count {
                let address = register.address + k * stride;
                let is_written = all.get(&address).is_some_and(|known| known.check != Check::Nothing);
                if !is_written {
                    all.insert(address, Register { address, ..register.clone() });
                }
            }
        }
        Self(all)
    }

    /// The registers that `bytes` from `address` on fill, each with its bytes.
    ///
    /// # Errors
    /// Where bytes fall between registers, or into a part of one; and as [`Register::accepts`].
    pub(crate) fn writes<'a>(
        &self,
        mut address: u32,
        mut bytes: &'a [u8],
    ) -> Result<Vec<(&Register, &'a [u8])>, Status> {
        let mut writes = Vec::new();
        while !bytes.is_empty() {
            let register = self.0.get(&address).ok_or(Status::InvalidAddress)?;
            let length = bytes.len().min(register.bytes as usize);
            let (own, rest) = bytes.split_at(length);
            if length < register.bytes as usize && !register.is_text() {
                return Err(Status::InvalidAddress);
            }
            register.accepts(own)?;
            writes.push((register, own));
            bytes = rest;
            address = address.checked_add(register.bytes).ok_or(Status::InvalidAddress)?;
        }
        Ok(writes)
    }
}
