//! A datagram of the device: status, code, length of what follows, number of the request, payload.

use super::status::Status;

/// The answer to a request.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Answer {
    /// How it went.
    pub status: Status,
    /// Code of the answer: that of the command and one.
    pub code: u16,
    /// Number of the request.
    pub id: u16,
}

/// The datagram of an answer; a payload beyond 65535 bytes does not occur in this protocol and is
/// cut off.
pub(crate) fn answer(answer: Answer, payload: &[u8]) -> Vec<u8> {
    let length = u16::try_from(payload.len()).unwrap_or(u16::MAX);
    let payload = &payload[..usize::from(length)];
    let mut datagram = Vec::with_capacity(8 + payload.len());
    for word in [answer.status.code(), answer.code, length, answer.id] {
        datagram.extend(word.to_be_bytes());
    }
    datagram.extend(payload);
    datagram
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_answer_is_laid_out_as_published() {
        let head = Answer { status: Status::AccessDenied, code: 0x0083, id: 0x0102 };
        let bytes = answer(head, &[0, 0, 0, 1]);
        assert_eq!(bytes, [0x80, 0x06, 0x00, 0x83, 0x00, 0x04, 0x01, 0x02, 0, 0, 0, 1]);
    }
}
