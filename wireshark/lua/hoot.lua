-- hoot, the MoCoBus protocol: break, address, sub-address, command, length and data. A reply does not say what it answers.
-- Serial lines, as DLT_USER1, or TCP by "Decode As".

local HEAD = { { "break", "bytes", size = 6 }, { "address", "u8" }, { "sub_address", "u8" } }
local function header(...)
  local list = {}
  for index, row in ipairs(HEAD) do list[index] = row end
  for _, row in ipairs({ ... }) do list[#list + 1] = row end
  return rows(list)
end
local LENGTH = { "length", "u8" }
local REQUEST = header({ "command", "u8" }, LENGTH)
local CORE = header({ "command", "u8" }, LENGTH, { "core_command", "u8" })
local REPLY = header({ "response_code", "u8", names = N.response_code }, LENGTH)

function next_frame(tvb, at)
  local bytes = tvb:raw()
  local begin = bytes:find(MARKER, at + 1, true)
  if not begin then
    -- The last bytes may be the begin of a break.
    local zeros = math.min(#bytes:match("%z*$"), 5, #bytes - at)
    if zeros == #bytes - at then return "more" end
    return "noise", #bytes - at - zeros
  end
  if begin > at + 1 then return "noise", begin - 1 - at end
  local length = bytes:byte(at + 10)
  if not length then return "more" end
  local size = 10 + length
  if #bytes - at >= size then return "frame", size end
  -- The rest of this packet is lost if another one begins.
  local other = bytes:find(MARKER, at + 11, true)
  if other then return "noise", other - 1 - at end
  return "more", size
end

-- Message whose data has this length; a command has exactly the data of its table.
local function fitting(candidates, tvb, at, left)
  for _, message in ipairs(candidates) do
    local size = 0
    for _, row in ipairs(message) do size = size + (row.size or 0) end
    local fits = left == size
    if message.name == "SetName" then fits = left >= 1 and left <= 10 end
    if message.name == "MotorMove" then fits = fits and tvb(at + 1, 4):uint() > 0 end
    if fits then return message end
  end
end

function read_frame(tvb, at, size, sender)
  local address, command = tvb(at + 6, 1):uint(), tvb(at + 8, 1):uint()
  local frame = { header = REQUEST, body = at + 10, stop = at + size, sub = tvb(at + 7, 1), tag = "" }
  frame.sender = sender or (address == 0 and "device" or "host")
  if frame.sender == "device" then
    frame.header = REPLY
    frame.answers = address == 0
    frame.message = messages_of("device", address * 65536 + tvb(at + 7, 2):uint())[1]
    if command ~= 1 then
      frame.finish = function(tree) tree:add_proto_expert_info(E.refused, "The node refuses the request") end
    end
    return frame
  end
  local bus = address == 1 and 1 or 0
  if bus == 0 and command == 1 and size > 10 then
    bus, command, frame.header, frame.body = 2, tvb(at + 10, 1):uint(), CORE, at + 11
  end
  local candidates = messages_of("host", bus * 65536 + command * 256 + tvb(at + 7, 1):uint())
  frame.message = fitting(candidates, tvb, frame.body, frame.stop - frame.body)
  if candidates[1] then frame.why = "The data is longer or shorter than that of " .. candidates[1].name end
  frame.asks = address > 1
  return frame
end

-- The byte in front of a value tells its type, and the query its meaning.
local VALUE_TYPE = rows({ { "value_type", "u8", names = N.value_type } })[1]
local VALUE = { [0] = "u8", "u16", "i16", "i32", "u32", "i32", "text" }
-- Fields of all values that answers may have, because none can be added later.
local VALUES = {}
local function value_row(kind, meaning)
  local row = { "value", kind }
  for key, what in pairs(meaning) do row[key] = what end
  local id = table.concat({ kind, tostring(row.names), tostring(row.flags) }, " ")
  VALUES[id] = VALUES[id] or field_of(row)
  row.field = VALUES[id]
  return row
end
for _, kind in pairs(VALUE) do value_row(kind, {}) end
for _, types in pairs(ANSWERS) do
  for value_type, meaning in pairs(types) do value_row(VALUE[value_type], meaning) end
end

function BY_HAND.Reply(tree, tvb, at, stop, _, frame)
  if at == stop then return stop end
  local value_type = tvb(at, 1):uint()
  local kind = VALUE[value_type]
  if not kind or (SIZE[kind] and stop - at - 1 ~= SIZE[kind]) then
    tree:add(F.data, tvb(at, stop - at))
    return stop
  end
  add_value(tree, VALUE_TYPE, tvb(at, 1))
  local query = frame.request and frame.request.message and frame.request.message.name
  local meaning = ANSWERS[query] and ANSWERS[query][value_type]
  if ANSWERS[query] and not meaning then
    tree:add_proto_expert_info(E.unasked, "This type does not answer the query " .. query)
  end
  local row = value_row(kind, meaning or (value_type == 5 and { decimals = 2 } or {}))
  if stop - at > 1 then add_value(tree, row, tvb(at + 1, stop - at - 1)) else tree:add(row.field, "") end
  return stop
end
proto.dissector = dissect
proto.fields, proto.experts = all_fields, E
DissectorTable.get("wtap_encap"):add(wtap_encaps.USER1, proto)
DissectorTable.get("tcp.port"):add_for_decode_as(proto)
