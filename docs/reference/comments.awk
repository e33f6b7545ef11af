# Doxygen's INPUT_FILTER: shows it the plain // comments of our headers as its own kind. The sources stay as they are; the
# lines that warnings name are those of the filter's output.
#   // lines above a declaration   -> ///    (left alone where a blank line follows: a heading)
#   // behind a declaration        -> ///<   (a struct's, behind its brace: above it)
#   // at the top of a file        -> \file
#   int a, b; // both              -> a declaration each, and the comment with each: Doxygen gives it to one
#   namespace ... { and }           -> nothing: Doxygen lists a namespace's functions on one page for all headers, and those
#                                      of no namespace on the page of their header
#   Memory: Thread: Failure: ...    -> a paragraph with that heading
#   "Example:" and lines indented   -> a block of code
#   a function of fjell_c.h         -> the name of its counterpart in C++, if it has no comment
# Bodies of functions are left alone.

# In a comment #word would be a link.
function escaped(text) { gsub(/#/, "\\#", text); return text }
function count(text, char) { return gsub(char, "", text) }

# A line of a comment, which begins with mark.
function show(text, mark,  words, start) {
  words = text
  sub(/^ *\/\/ ?/, "", words)
  if (words ~ /^    / && !coded) print mark " \\code{.cpp}"
  if (words !~ /^    / && coded) print mark " \\endcode"
  coded = words ~ /^    /
  if (coded) { gsub(/\\#/, "#", words); print mark " " substr(words, 5); return }
  while (match(words, /(^|\. )(Memory|Ownership|Threads?|Complexity|Failure|Units|Positions|Linking|Example)[^:.]*: ?/)) {
    start = words ~ /^[MOTCFUPLE]/ && RSTART == 1 ? 1 : RSTART + 2
    if (start > 1) print mark " " substr(words, 1, start - 2)
    print mark " \\par " substr(words, start, index(substr(words, start), ":") - 1)
    words = substr(words, RSTART + RLENGTH)
    if (words ~ /^[a-z]+[ ,]/) words = toupper(substr(words, 1, 1)) substr(words, 2)
  }
  print mark " " words
}

# Prints the lines of comment that were held back, marked or as they are.
function flush(mark,  i) {
  above = ""
  for (i = 0; i < held; ++i)
    if (mark == "") print lines[i]
    else { above = above substr(lines[i], index(lines[i], "//") + 2); show(lines[i], mark) }
  if (coded) { print mark " \\endcode"; coded = 0 }
  held = 0
}

# int a = 1, b[2]; behind: what stands behind them. False: there is but one.
function declare_each(code, behind,  i, c, nest, parts, n, part, type, line) {
  sub(/; *$/, "", code)
  n = 1; nest = 0; parts[1] = ""
  for (i = 1; i <= length(code); ++i) {
    c = substr(code, i, 1)
    if (c ~ /[({[]/) ++nest
    if (c ~ /[)}\]]/) --nest
    if (c == "," && nest == 0) parts[++n] = ""
    else parts[n] = parts[n] c
  }
  if (n == 1) return 0
  match(parts[1], /[A-Za-z_0-9]+ *([={[].*)?$/)
  type = substr(parts[1], 1, RSTART - 1)
  line = parts[1] ";"
  for (i = 1; i <= n; ++i) {
    if (i > 1) line = line (above == "" ? "" : " /**" above " */") type parts[i] ";"
    if (behind != "") line = line " /**< " behind " */"
  }
  print line
  return 1
}

BEGIN { top = 1; depth = 0; body = 0 }

{ at = index($0, "//"); if (at > 0) $0 = substr($0, 1, at - 1) escaped(substr($0, at)) }

top && /^\/\// { # the comment that opens a file
  if (NR == 1) print "/// \\file"
  show($0, "///")
  next
}
{ if (top && coded) { print "/// \\endcode"; coded = 0 }; top = 0 }

/^namespace .*{ *$/ || /^} \/\/ namespace/ { flush(""); next }
/^\/\/ --- / { header = $3 ~ /^fjell\// ? $3 : "" } # in fjell_c.h: whose functions follow

/^ *\/\// { hold_at = index($0, "//"); lines[held++] = $0; next }
/^ *$/ { flush(""); print; next }

{
  code = $0; comment = ""
  at = index($0, " // ")
  if (at > 0) { code = substr($0, 1, at); comment = substr($0, at + 4) }
  plain = code; gsub(/"[^"]*"|'[^']*'/, "", plain)
  indent = code; gsub(/[^ ].*/, "", indent)

  if (header != "" && held == 0 && comment == "" && match(plain, /fjell_[a-z_0-9]+\(/)) {
    name = substr(plain, RSTART + 6, RLENGTH - 7)
    sub(/^validate_.*/, "validate", name)
    sub(/^bound_.*/, "bound_error_px", name)
    if (header == "fjell/terrain.h" && name != "terrain_bytes") sub(/^terrain_/, "Terrain::", name)
    print "/// The C++ function " name "() of " header "."
  }
  flush(body || plain ~ /^ *[}#]/ ? "" : "///")
  if (body || plain ~ /^ *[}#]/) print
  else if (plain ~ /; *$/ && plain !~ /[()]|^ *(friend|using|template|return|enum)|<[^>]*,/ && declare_each(code, comment)) ;
  else if (comment == "") print
  else if (plain ~ /{ *$/) print indent "/** " comment " */ " code
  else print code "///< " comment

  if (!body && plain ~ /\).*{ *$/) body = depth + 1
  depth += count(plain, "{") - count(plain, "}")
  if (body && depth < body) body = 0
}
END { flush("") }
