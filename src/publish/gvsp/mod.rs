//! GVSP, the stream protocol of GigE Vision (AIA GigE Vision 2.2, chapters 23 to 26): a frame is a
//! block of packets, the leader first, the pixels, the trailer last; every number big-endian.
//!
//! In: pixels, what the leader states of them and the size of a packet. Out: packets by their
//! number, so that one can be sent again as it was. `pixels` packs grey values into the seven
//! formats of the PFNC that the head streams, `chunks` appends values to a frame, `block` lays a
//! frame out in packets. Nothing of ours is imported but the vocabulary of frames. One more pixel
//! format is a variant of [`StreamFormat`], one more chunk a variant of [`Chunk`].

mod block;
mod chunks;
mod pixels;

pub(crate) use block::{Block, Ids, Leader, MIN_PACKET_BYTES, UDP_IP_HEADER_BYTES, lone_packet};
pub(crate) use chunks::{Chunk, ChunkValues, append_chunks, chunk_bytes};
pub(crate) use pixels::{StreamFormat, pack, packed_bytes};
