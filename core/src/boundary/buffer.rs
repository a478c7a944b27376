//! One reference-counted array with a C layout for everything big: grids, ranges, points, depth.
//!
//! A clone bumps one count; [`Buffer::make_mut`] copies only while somebody else holds the same array. The block
//! starts with a sized header that carries its own `retain` and `release`, so that code built by another compiler can
//! keep and drop a buffer without knowing how it was allocated.
#![allow(unsafe_code)]

use std::alloc::{Layout, alloc, dealloc, handle_alloc_error};
use std::fmt;
use std::marker::PhantomData;
use std::ops::Deref;
use std::ptr::{self, NonNull};
use std::sync::atomic::{AtomicPtr, AtomicUsize, Ordering, fence};

use super::abi::rumbo_block;

/// Element types a [`Buffer`] may hold: fixed layout, no padding that matters, no destructor.
///
/// # Safety
/// The type must be `#[repr(C)]` or primitive, `Copy`, free of pointers, and valid for every bit pattern that the
/// framework writes into it.
pub unsafe trait Plain: Copy + Default + Send + Sync + 'static {}

macro_rules! plain {
    ($($t:ty),*) => { $(
        // SAFETY: numbers, or `repr(C)` structs and arrays of numbers without padding: no invalid bit pattern.
        unsafe impl Plain for $t {}
    )* };
}
plain!(u8, i8, u16, i16, u32, i32, u64, i64, f32, f64, [f32; 2], [f32; 3], [f64; 2], [f64; 3]);
plain!(crate::map::Line, crate::map::Landmark);

/// Header in front of the elements. Append-only: a reader checks `size` before it reads a later field.
#[repr(C)]
struct Block {
    size: usize,
    count: AtomicUsize,
    capacity_bytes: usize,
    retain: extern "C" fn(*mut Block),
    release: extern "C" fn(*mut Block),
}

/// Elements start here; 64 keeps rows on cache lines for vector loads.
const HEADER_BYTES: usize = 64;
const ALIGN: usize = 64;
const _: () = assert!(size_of::<Block>() <= HEADER_BYTES);

fn layout(capacity_bytes: usize) -> Option<Layout> {
    Layout::from_size_align(HEADER_BYTES.checked_add(capacity_bytes)?, ALIGN).ok()
}

extern "C" fn retain(block: *mut Block) {
    // SAFETY: the caller holds a reference, so the block is alive.
    unsafe { (*block).count.fetch_add(1, Ordering::Relaxed) };
}

extern "C" fn release(block: *mut Block) {
    // SAFETY: the caller gives up one reference; the last one frees with the layout of the allocation.
    unsafe {
        if (*block).count.fetch_sub(1, Ordering::Release) == 1 {
            fence(Ordering::Acquire);
            if let Some(layout) = layout((*block).capacity_bytes) {
                dealloc(block.cast(), layout);
            }
        }
    }
}

/// The allocating function of the host, in a plugin's library: whatever one side may free later is the host's.
static HOST_BLOCKS: AtomicPtr<rumbo_block> = AtomicPtr::new(ptr::null_mut());

/// Makes a fresh block for so many bytes of elements, or null where there is no memory.
pub(super) type BlockMaker = unsafe extern "C" fn(usize) -> *mut rumbo_block;

/// From now on blocks come from the host.
pub(super) fn allocate_with(host: BlockMaker) {
    HOST_BLOCKS.store(host as *mut rumbo_block, Ordering::Release);
}

fn allocate(capacity_bytes: usize) -> *mut Block {
    let host = HOST_BLOCKS.load(Ordering::Acquire);
    if host.is_null() {
        return allocate_here(capacity_bytes).cast();
    }
    // SAFETY: only `allocate_with` writes it, always a function of this type.
    let host = unsafe { std::mem::transmute::<*mut rumbo_block, BlockMaker>(host) };
    // SAFETY: the host's functions live as long as the program.
    unsafe { host(capacity_bytes) }.cast()
}

/// A fresh block of this program's own allocator with one reference; null where there is no memory.
pub(super) fn allocate_here(capacity_bytes: usize) -> *mut rumbo_block {
    let Some(layout) = layout(capacity_bytes) else { return ptr::null_mut() };
    // SAFETY: the layout has a non-zero size.
    let block = unsafe { alloc(layout) }.cast::<Block>();
    if !block.is_null() {
        let header =
            Block { size: size_of::<Block>(), count: AtomicUsize::new(1), capacity_bytes, retain, release };
        // SAFETY: the block is fresh, aligned and large enough for the header.
        unsafe { block.write(header) };
    }
    block.cast()
}

/// One more reference.
///
/// # Safety
/// `block` is null or alive.
pub(super) unsafe fn retain_block(block: *mut rumbo_block) {
    if !block.is_null() {
        // SAFETY: as promised by the caller.
        unsafe { ((*block.cast::<Block>()).retain)(block.cast()) };
    }
}

/// One reference less.
///
/// # Safety
/// `block` is null or alive, and the caller holds a reference.
pub(super) unsafe fn release_block(block: *mut rumbo_block) {
    if !block.is_null() {
        // SAFETY: as promised by the caller.
        unsafe { ((*block.cast::<Block>()).release)(block.cast()) };
    }
}

/// A reference-counted array of plain elements.
#[repr(C)]
pub struct Buffer<T: Plain> {
    block: *mut Block,
    len: usize,
    element: PhantomData<T>,
}

// SAFETY: the count is atomic and elements are plain `Send + Sync` values; mutation needs the only reference.
unsafe impl<T: Plain> Send for Buffer<T> {}
// SAFETY: as above.
unsafe impl<T: Plain> Sync for Buffer<T> {}

impl<T: Plain> Buffer<T> {
    const FITS: () = assert!(align_of::<T>() <= ALIGN);

    /// An array of nothing; allocates nothing.
    pub const fn empty() -> Self {
        Buffer { block: ptr::null_mut(), len: 0, element: PhantomData }
    }

    /// `len` elements, each the default (zero).
    pub fn zeroed(len: usize) -> Self {
        Self::filled(len, T::default())
    }

    /// `len` copies of `value`.
    pub fn filled(len: usize, value: T) -> Self {
        let mut buffer = Self::with_capacity(len);
        buffer.len = len;
        let start = buffer.start();
        for idx in 0..len {
            // SAFETY: `idx < len <= capacity`, and this buffer is the only owner of the fresh block.
            unsafe { start.add(idx).write(value) };
        }
        buffer
    }

    fn with_capacity(len: usize) -> Self {
        let () = Self::FITS;
        if len == 0 {
            return Self::empty();
        }
        let bytes = len.saturating_mul(size_of::<T>());
        let block = allocate(bytes);
        if block.is_null() {
            handle_alloc_error(layout(bytes).unwrap_or(Layout::new::<T>()))
        }
        Buffer { block, len: 0, element: PhantomData }
    }

    /// The block that holds the elements; null for none.
    pub(super) fn block(&self) -> *mut rumbo_block {
        self.block.cast()
    }

    /// A buffer over `len` elements of a block, whose reference it takes; none where they do not fit (the reference is
    /// given up all the same).
    ///
    /// # Safety
    /// The block is alive, was made by the host's allocation, and a reference of it changes hands.
    pub(super) unsafe fn from_block(block: *mut rumbo_block, len: usize) -> Option<Self> {
        let mut buffer = Buffer { block: block.cast::<Block>(), len: 0, element: PhantomData };
        let fits = len <= buffer.capacity();
        buffer.len = if fits { len } else { 0 };
        fits.then_some(buffer)
    }

    fn start(&self) -> *mut T {
        if self.block.is_null() {
            return NonNull::<T>::dangling().as_ptr();
        }
        // SAFETY: elements start `HEADER_BYTES` into the same allocation.
        unsafe { self.block.cast::<u8>().add(HEADER_BYTES).cast::<T>() }
    }

    /// The elements.
    pub fn as_slice(&self) -> &[T] {
        // SAFETY: `len` elements were written, and nobody writes while a shared reference exists.
        unsafe { std::slice::from_raw_parts(self.start(), self.len) }
    }

    /// The elements for writing; copies them first if anybody else holds this buffer.
    pub fn make_mut(&mut self) -> &mut [T] {
        if !self.is_unique() {
            *self = Self::from(self.as_slice());
        }
        // SAFETY: this is the only reference, as checked or made above.
        unsafe { std::slice::from_raw_parts_mut(self.start(), self.len) }
    }

    /// Nobody else holds this array.
    pub fn is_unique(&self) -> bool {
        // SAFETY: a non-null block is alive while this buffer is.
        self.block.is_null() || unsafe { (*self.block).count.load(Ordering::Acquire) } == 1
    }

    /// How many elements fit without a new allocation.
    pub fn capacity(&self) -> usize {
        if self.block.is_null() {
            return 0;
        }
        // SAFETY: a non-null block is alive while this buffer is.
        unsafe { (*self.block).capacity_bytes / size_of::<T>() }
    }

    /// Changes the length inside the capacity of an unshared buffer, filling new elements with the default.
    /// Returns whether it fitted; on `false` nothing changed.
    pub fn try_resize(&mut self, len: usize) -> bool {
        if !self.is_unique() || len > self.capacity() {
            return false;
        }
        for idx in self.len..len {
            // SAFETY: unshared, and `idx < capacity`.
            unsafe { self.start().add(idx).write(T::default()) };
        }
        self.len = len;
        true
    }
}

impl<T: Plain> Clone for Buffer<T> {
    fn clone(&self) -> Self {
        if !self.block.is_null() {
            // SAFETY: this buffer holds a reference, so the block and its function are alive.
            unsafe { ((*self.block).retain)(self.block) };
        }
        Buffer { block: self.block, len: self.len, element: PhantomData }
    }
}

impl<T: Plain> Drop for Buffer<T> {
    fn drop(&mut self) {
        if !self.block.is_null() {
            // SAFETY: gives up the reference this buffer holds, exactly once.
            unsafe { ((*self.block).release)(self.block) };
        }
    }
}

impl<T: Plain> From<&[T]> for Buffer<T> {
    fn from(values: &[T]) -> Self {
        let mut buffer = Self::with_capacity(values.len());
        // SAFETY: the fresh block has room for all elements and cannot overlap `values`.
        unsafe { ptr::copy_nonoverlapping(values.as_ptr(), buffer.start(), values.len()) };
        buffer.len = values.len();
        buffer
    }
}

impl<T: Plain> From<Vec<T>> for Buffer<T> {
    fn from(values: Vec<T>) -> Self {
        Self::from(values.as_slice())
    }
}

impl<T: Plain> Default for Buffer<T> {
    fn default() -> Self {
        Self::empty()
    }
}

impl<T: Plain> Deref for Buffer<T> {
    type Target = [T];
    fn deref(&self) -> &[T] {
        self.as_slice()
    }
}

impl<T: Plain + fmt::Debug> fmt::Debug for Buffer<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Buffer({} elements)", self.len)
    }
}

impl<T: Plain + PartialEq> PartialEq for Buffer<T> {
    fn eq(&self, other: &Self) -> bool {
        self.as_slice() == other.as_slice()
    }
}

/// Buffers that came back, to be handed out again: a warm loop allocates nothing.
#[derive(Debug)]
pub struct BufferPool<T: Plain> {
    idle: Vec<Buffer<T>>,
}

impl<T: Plain> BufferPool<T> {
    /// Keeps at most this many idle buffers.
    const MOST_IDLE: usize = 256;

    /// A buffer of `len` default elements, reused where one fits.
    pub fn take(&mut self, len: usize) -> Buffer<T> {
        if let Some(idx) = self.idle.iter().rposition(|b| b.capacity() >= len) {
            let mut buffer = self.idle.swap_remove(idx);
            if buffer.try_resize(0) && buffer.try_resize(len) {
                return buffer;
            }
        }
        Buffer::zeroed(len)
    }

    /// Gives a buffer back; one that is still shared is simply dropped.
    pub fn recycle(&mut self, buffer: Buffer<T>) {
        if buffer.capacity() > 0 && buffer.is_unique() && self.idle.len() < Self::MOST_IDLE {
            self.idle.push(buffer);
        }
    }
}

impl<T: Plain> Default for BufferPool<T> {
    fn default() -> Self {
        BufferPool { idle: Vec::with_capacity(Self::MOST_IDLE) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_clone_shares_and_a_write_to_a_shared_buffer_copies() {
        let mut a = Buffer::from(vec![1.0f32, 2.0, 3.0]);
        let b = a.clone();
        assert_eq!(a.as_slice().as_ptr(), b.as_slice().as_ptr());
        assert!(!a.is_unique());
        a.make_mut()[0] = 9.0;
        assert_eq!((a[0], b[0]), (9.0, 1.0));
        assert!(a.is_unique() && b.is_unique());
    }

    #[test]
    fn a_write_to_an_unshared_buffer_stays_in_place() {
        let mut a = Buffer::<u16>::filled(1000, 7);
        let before = a.as_slice().as_ptr();
        a.make_mut()[999] = 8;
        assert_eq!(a.as_slice().as_ptr(), before);
        assert_eq!(a.as_slice().as_ptr() as usize % ALIGN, 0);
    }

    #[test]
    fn empty_buffers_work_everywhere() {
        let mut a = Buffer::<f64>::empty();
        assert!(a.clone().is_empty() && a.make_mut().is_empty() && a.is_unique());
        assert!(!a.try_resize(1));
        assert_eq!(Buffer::<f64>::from(Vec::new()), a);
    }

    #[test]
    fn buffers_dropped_on_many_threads_are_freed_once() {
        let a = Buffer::<u64>::filled(100, 1);
        std::thread::scope(|s| {
            for _ in 0..8 {
                let b = a.clone();
                s.spawn(move || (0..100).for_each(|_| drop(b.clone())));
            }
        });
        assert!(a.is_unique());
    }

    #[test]
    fn a_pool_hands_the_same_memory_out_again() {
        let mut pool = BufferPool::<f32>::default();
        let mut a = pool.take(361);
        a.make_mut()[5] = 4.0;
        let address = a.as_slice().as_ptr();
        pool.recycle(a);
        let b = pool.take(181);
        assert_eq!(b.as_slice().as_ptr(), address);
        assert!(b.iter().all(|v| *v == 0.0));
        let shared = b.clone();
        pool.recycle(b);
        assert_ne!(pool.take(181).as_slice().as_ptr(), shared.as_slice().as_ptr());
    }
}
