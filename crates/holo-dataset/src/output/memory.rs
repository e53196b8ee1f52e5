//! Whether there is memory for an image, before it is computed.

/// Whether this much memory can be allocated.
pub(crate) fn is_room(bytes: usize) -> bool {
    let mut room = Vec::<u8>::new();
    let is_room = room.try_reserve_exact(bytes).is_ok();
    // Otherwise the compiler may remove the allocation.
    std::hint::black_box(&room);
    is_room
}
