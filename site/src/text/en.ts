// Every text of the site in English; `{name}` is filled in. Another language has the same keys.

export const en = {
  "read.missing": "Nothing was answered.",
  "read.unreadable": "This can't be read as an answer: {why}.",
  "read.shape": "The answer has {found} entries; it should have {due} (rows × columns).",
  "read.list": "A list or matrix stands where a single expression is due.",
  "read.numbers": "Numbers are due, and {names} is left in the answer.",
  "verdict.values": "Equal to the right answer at {points} random configurations, to nine digits.",
  "verdict.branches":
    "Equal at all {points} configurations that were tried. An answer with {functions} may differ where none was tried: " +
    "the grader of qdot looks at more of them.",
  "verdict.decimals":
    "Equal at {points} random configurations to nine digits. Your decimals have {digits} digits: the grader of qdot takes " +
    "them for what they say, and not for pi or a root.",
  "verdict.entry": "Entry ({row}, {column}) differs at {at}: yours {yours}, expected {expected}.",
  "verdict.differs": "It differs at {at}: yours {yours}, expected {expected}.",
  "verdict.entries": "{right} of {count} entries are right.",
  "verdict.blank": "Entry ({row}, {column}) was left blank.",
  "verdict.undefined": "undefined",
  "verdict.number": "Number {index}: yours {yours}, expected {expected}.",
  "verdict.numbers": "Right to {percent} %.",
  "verdict.direction": "Along the right direction.",
  "verdict.not-along": "Not along the right direction at {at}.",
  "verdict.zero-vector": "The zero vector is no direction.",
  "verdict.set":
    "These are the singular configurations: every one that was tried is covered, and none too many.",
  "verdict.unsound": "At {at} your answer says singular, and J has full rank there.",
  "verdict.uncovered": "At {at} the arm is singular, and your answer does not say so.",
  "verdict.nowhere": "No configuration could be found at which this holds: {text}.",
  "verdict.letter": "{letter} is not the right option.",
  "verdict.no-letter": "“{said}” is none of the options {letters}.",
  "verdict.letters": "{hits} of the letters are right, {misses} are not.",
  "verdict.matching": "Not right for {items}.",
  "verdict.right-letter": "Right.",
} as const;

export type TextKey = keyof typeof en;
export type Catalogue = Readonly<Record<TextKey, string>>;
