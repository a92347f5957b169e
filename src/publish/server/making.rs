//! Has frames made ahead of their time.

use std::sync::mpsc::{Receiver, SyncSender};

use super::shared::Shared;
use crate::frame::Frame;
use crate::publish::camera::{FrameTask, Task};
use crate::publish::head::FrameMaker;

/// A frame that waits to be sent.
#[derive(Debug)]
pub(crate) struct Made {
    pub(super) task: Box<FrameTask>,
    pub(super) frame: Frame,
}

/// Makes one task after another until the end.
pub(super) fn make(
    shared: &Shared<'_>,
    maker: &mut (dyn FrameMaker + Send),
    made: &SyncSender<Made>,
    spare: &Receiver<Frame>,
) {
    while let Some(task) = shared.next_task() {
        match task {
            Task::Cut(order) => {
                let result = maker.cut(&order);
                if let Err(why) = &result {
                    tracing::warn!("pass {} was not cut: {why}", order.pass);
                }
                shared.with(|camera| camera.pass_ended(&result));
            }
            Task::Frame(task) => match maker.frame(&task.order, spare.try_recv().ok()) {
                Ok(frame) => {
                    if made.send(Made { task, frame }).is_err() {
                        return;
                    }
                }
                Err(why) => {
                    tracing::warn!("the acquisition ends: frame {} was not taken: {why}", task.order.number);
                    shared.with(|camera| camera.frame_refused(&why));
                }
            },
        }
    }
}
