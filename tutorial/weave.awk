# Writes a chapter's README anew from its program: listings, the program's output, and the numbers that the text quotes
# from it. awk -v sources='main.c ...' -v output=OUTPUT -f weave.awk README.md. SPDX-License-Identifier: MIT
#   <!-- code NAME -->    the block that follows is what stands between // [NAME] and // [/NAME] in the
#                         first source that has it
#   <!-- output -->       the block that follows is what the program printed
#   <!-- table -->        the table that follows is the one with its first line that the program printed
#   0.82<!-- = KEY -->    the first number behind KEY in the output; "A ... B" is B behind A
function stop(text) {
    printf "%s: %s\n", FILENAME, text > "/dev/stderr"
    failed = 1
    exit 1
}
function replace_block(text) {
    print
    if (text == "") stop("nothing for " $0)
    if ((getline) <= 0 || $0 !~ /^```/) stop("no block after a mark")
    print
    printf "%s", text
    while ((getline) > 0 && $0 != "```") continue
}
function replace_table(head, text) {
    print
    if ((getline head) <= 0 || head !~ /^\|/) stop("no table after a mark")
    if (!index(printed, head "\n")) stop("no table begins with " head)
    text = substr(printed, index(printed, head "\n"))
    match(text, /^(\|[^\n]*\n)+/)
    printf "%s", substr(text, 1, RLENGTH)
    while ((getline) > 0 && $0 ~ /^\|/) continue
}
function number_behind(key, rest, parts, n, i, at) {
    rest = printed
    n = split(key, parts, " [.][.][.] ")
    for (i = 1; i <= n; i++) {
        at = index(rest, parts[i])
        if (!at) stop("the program does not print \"" parts[i] "\"")
        rest = substr(rest, at + length(parts[i]))
    }
    if (!match(rest, /-?[0-9]+([.][0-9]+)?(e[-+][0-9]+)?/)) stop("no number behind \"" key "\"")
    return substr(rest, RSTART, RLENGTH)
}
function quote_numbers(line, done, mark, from, size) {
    while (match(line, /[0-9.e+-]*[0-9]<!-- = [^>]* -->/)) {
        from = RSTART # the calls below set both anew
        size = RLENGTH
        mark = substr(line, from, size)
        sub(/^[^<]*<!-- = /, "", mark)
        sub(/ -->$/, "", mark)
        done = done substr(line, 1, from - 1) number_behind(mark) "<!-- = " mark " -->"
        line = substr(line, from + size)
    }
    return done line
}
BEGIN {
    files = split(sources, source, " ")
    for (i = files; i >= 1; i--) {
        while ((getline line < source[i]) > 0) {
            if (line ~ /^\/\/ \[\/.*\]$/) name = ""
            else if (line ~ /^\/\/ \[.*\]$/) {
                name = substr(line, 5, length(line) - 5)
                code[name] = ""
            } else if (name != "") code[name] = code[name] line "\n"
        }
    }
    while ((getline line < output) > 0) printed = printed line "\n"
}
/^<!-- code .* -->$/ { replace_block(code[$3]) }
/^<!-- output -->$/ { replace_block(printed) }
/^<!-- table -->$/ { replace_table() }
{ print quote_numbers($0) }
END { if (failed) exit 1 }
