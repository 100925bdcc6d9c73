// SPDX-License-Identifier: BSD-3-Clause
#include "bus/udpm/fragment_assembler.hpp"

#include <algorithm>

namespace slam {

std::optional<FragmentAssembler::Whole> FragmentAssembler::take(const Fragment& fragment,
                                                                const std::function<bool(std::string_view)>& wanted) {
  auto at = std::find_if(unfinished_.begin(), unfinished_.end(), [&](const Unfinished& u) {
    return u.next > 0 && u.next < u.parts && u.sequence == fragment.sequence && u.size == fragment.size &&
           u.parts == fragment.count;
  });
  if (fragment.number == 0) {
    if (fragment.size > kLargest || fragment.count < 2 || !wanted(fragment.channel)) return std::nullopt;
    if (at == unfinished_.end()) at = unfinished_.begin() + static_cast<std::ptrdiff_t>(oldest_++ % kUnfinished);
    at->sequence = fragment.sequence;
    at->size = fragment.size;
    at->parts = fragment.count;
    at->next = 0;
    at->channel = fragment.channel;
    at->data.clear();
  }
  if (at == unfinished_.end()) return std::nullopt;
  // They come in order on one network, as liblcm sends them; a gap is a part that was lost.
  const bool follows = fragment.number == at->next && fragment.offset == at->data.size() &&
                       fragment.data.size() <= at->size - at->data.size();
  if (!follows) {
    at->next = 0;
    return std::nullopt;
  }
  at->data.insert(at->data.end(), fragment.data.begin(), fragment.data.end());
  if (++at->next < at->parts) return std::nullopt;
  if (at->data.size() != at->size) return std::nullopt;
  return Whole{at->channel, at->data};
}

}  // namespace slam
