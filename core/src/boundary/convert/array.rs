//! Shared arrays: a buffer on this side, block and length on the other. Elements are never copied.
#![allow(unsafe_code)]

use crate::boundary::abi::{
    rumbo_block, rumbo_f32_array, rumbo_landmark_array, rumbo_line_array, rumbo_point3_array, rumbo_u8_array,
    rumbo_u16_array,
};
use crate::boundary::buffer::{Buffer, Plain};
use crate::map::{Landmark, Line};

/// What becomes of the reference that an array holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Hold {
    /// The other side keeps it; whoever reads takes one of its own.
    Lent,
    /// It changes hands.
    Given,
}

/// An array that does not hold together.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("an array of {len} elements has {problem}")]
pub struct BadArray {
    len: usize,
    problem: &'static str,
}

/// An array type of the ABI.
pub(crate) trait CArray: Copy {
    /// Its elements here.
    type Item: Plain;

    /// From its parts.
    fn of(block: *mut rumbo_block, len: usize, data: *const Self::Item) -> Self;
    /// Its parts.
    fn parts(&self) -> (*mut rumbo_block, usize, *const Self::Item);

    /// No elements.
    fn nothing() -> Self {
        Self::of(std::ptr::null_mut(), 0, std::ptr::null())
    }

    /// A view of a buffer, which keeps its reference.
    fn lend(buffer: &Buffer<Self::Item>) -> Self {
        Self::of(buffer.block(), buffer.len(), buffer.as_slice().as_ptr())
    }

    /// Hands a buffer's reference over.
    fn give(buffer: Buffer<Self::Item>) -> Self {
        let view = Self::lend(&buffer);
        std::mem::forget(buffer);
        view
    }

    /// The buffer behind a view.
    ///
    /// # Safety
    /// The block, if any, is one that the host allocated and that is alive; without one, `data` points to `len` elements.
    unsafe fn take(&self, hold: Hold) -> Result<Buffer<Self::Item>, BadArray> {
        let (block, len, data) = self.parts();
        if block.is_null() {
            return match (len, data.is_null()) {
                (0, _) => Ok(Buffer::empty()),
                (_, true) => Err(BadArray { len, problem: "neither a block nor data" }),
                // SAFETY: as promised by the caller.
                (_, false) => Ok(Buffer::from(unsafe { std::slice::from_raw_parts(data, len) })),
            };
        }
        // SAFETY: as promised by the caller.
        let buffer = unsafe { Buffer::from_block(block, len) };
        let buffer = buffer.ok_or(BadArray { len, problem: "a block that is smaller" })?;
        if hold == Hold::Lent {
            // The reference of the view stays with the lender.
            std::mem::forget(buffer.clone());
        }
        Ok(buffer)
    }
}

macro_rules! array {
    ($($array:ident: $item:ty => $c_item:ty),* $(,)?) => { $(
        impl CArray for $array {
            type Item = $item;
            fn of(block: *mut rumbo_block, len: usize, data: *const $item) -> Self {
                $array { block, len, data: data.cast::<$c_item>() }
            }
            fn parts(&self) -> (*mut rumbo_block, usize, *const $item) {
                (self.block, self.len, self.data.cast::<$item>())
            }
        }
        const _: () = assert!(size_of::<$item>() == size_of::<$c_item>());
        const _: () = assert!(align_of::<$item>() == align_of::<$c_item>());
    )* };
}
array!(
    rumbo_f32_array: f32 => f32,
    rumbo_u16_array: u16 => u16,
    rumbo_u8_array: u8 => u8,
    rumbo_point3_array: [f32; 3] => [f32; 3],
    rumbo_line_array: Line => crate::boundary::abi::rumbo_line,
    rumbo_landmark_array: Landmark => crate::boundary::abi::rumbo_landmark,
);
