#pragma once
#include <type_traits>

namespace kawara::core {

/// True for types whose objects may be carried as plain bytes (std::memcpy out and back in). Every
/// trivially copyable type is; structs of fixed-size Eigen matrices are too (plain arrays inside),
/// but Eigen's user-written copy constructors hide it from the compiler, so they opt in next to
/// their definition:
///     template <> inline constexpr bool kMemcpySafe<GnssFix> = true;
template <class T>
inline constexpr bool kMemcpySafe = std::is_trivially_copyable_v<T>;

}  // namespace kawara::core
