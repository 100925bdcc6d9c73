// SPDX-License-Identifier: BSD-3-Clause
"use strict";

// ---- the token, and words of answers ---------------------------------------------------------------------------------

// The address of `slamctl web --qr` has it behind #, which browsers send to nobody.
const brought = new URLSearchParams(location.hash.slice(1)).get("token");
if (brought) history.replaceState(null, "", location.pathname);
let token = brought || sessionStorage.getItem("slamd-token") || "", unlocked = false;

const authorized = () => ({ "Content-Type": "application/json", Authorization: "Bearer " + token });

/// The message of an answer, whether it is JSON or a refusal in plain text: in German by the rows that it is made of.
async function messageOf(answer) {
  const text = await answer.text();
  let message = text.trim(), parts = JSON.parse(answer.headers.get("Slamd-Parts") || "[]");
  try { ({ message, parts = [] } = JSON.parse(text)); } catch (error) { /* plain text */ }
  return sentenceOf(message, parts);
}
