-- kOS: a header of six bytes, and no checksum. TCP and UDP at port 5520, HID reports over USB.

proto.prefs.secrets = Pref.bool("Show passwords", false, "Passwords travel in clear. They are shown only if this is set.")
each_rows(BLOCKS)

local HEADER = rows({
  { "version", "u8" }, { "length", "u16" }, { "message_id", "u16", names = N.message_id },
  { "message_type", "u8", names = N.message_type },
})
local function header_with(name)
  local list = {}
  for index, row in ipairs(HEADER) do list[index] = row end
  list[#list + 1] = rows({ { name, "u8" } })[1]
  return list
end
local ACTION, NOTIFICATION = header_with("action_id"), header_with("note_id")
local PADDING = keep(ProtoField.bytes(KEY .. ".padding", "Padding of the report"))

function next_frame(tvb, at)
  local left = tvb:len() - at
  if tvb(at, 1):uint() ~= 4 then return "noise", left end
  if left < 3 then return "more" end
  local size = tvb(at + 1, 2):uint()
  if size < 6 then return "noise", left end
  if size > left then return "more", size end
  return "frame", size
end

function read_frame(tvb, at, size, sender)
  local id, kind = tvb(at + 3, 2):uint(), tvb(at + 5, 1):uint()
  local frame = { header = HEADER, body = at + 6, stop = at + size, tag = id }
  frame.sender = sender or (kind < 2 and "host" or "device")
  local number = id * 65536 + kind * 256
  if id == 0x80 and kind == 0 then frame.header = ACTION end
  if id == 0x81 and kind == 2 then frame.header = NOTIFICATION end
  if frame.header ~= HEADER then
    if size > 6 then
      number, frame.body = number + tvb(at + 6, 1):uint(), at + 7
    else
      number, frame.header = -1, HEADER
      frame.fault, frame.why = E.short, "The number of the action or notification is missing"
    end
  end
  frame.message = messages_of(frame.sender, number)[1]
  frame.asks = frame.sender == "host" and kind == 1
  frame.more = kind == 0x82
  frame.answers = frame.sender == "device" and id ~= 0x81
  -- Devices announce their address.
  frame.unasked = id == 2
  local name = frame.message and frame.message.name
  if name == "ErrorStatus" or name == "UnsupportedMessage" then
    frame.finish = function(tree) tree:add_proto_expert_info(E.refused, "The device reports " .. name) end
  end
  return frame
end

-- Devices of the older dialect leave a field out. The length of the body tells the dialects apart.
local function without(message, name)
  local list = {}
  for index, row in ipairs(message) do
    if row[1] ~= name then list[#list + 1] = row end
    if row.of then
      local older = { row[1], "bytes", count = row.count, of = without(row.of, name) }
      list[#list] = rows({ older })[1]
    end
  end
  return list
end

local function dialects(name, left_out, is_older)
  local older
  BY_HAND[name] = function(tree, tvb, at, stop, message)
    older = older or without(message, left_out)
    return add_rows(tree, tvb, at, stop, is_older(tvb, at, stop - at) and older or message)
  end
end
dialects("MotorInfo", "begin_position", function(tvb, at, left)
  return left > 1 and left == 1 + 21 * tvb(at, 1):uint()
end)
dialects("PlaybackStatus", "photo_count", function(tvb, at, left)
  return left > 5 and left == 6 + 5 * tvb(at + 5, 1):uint()
end)
dialects("MotorCalibrated", "begin_position", function(_, _, left) return left == 5 end)

-- A move is a list of blocks, each with a number, a length and data.
local BLOCK_COUNT = rows({ { "block_count", "u8" } })[1]
local BLOCK = rows({ { "block_id", "u8" }, { "block_length", "u16" } })
local function add_move(tree, tvb, at, stop)
  if at == stop then return nil, "block_count", at end
  local count = tvb(at, 1):uint()
  add_value(tree, BLOCK_COUNT, tvb(at, 1))
  at = at + 1
  for _ = 1, count do
    if stop - at < 3 then return nil, "a block", at end
    local id, size = tvb(at, 1):uint(), tvb(at + 1, 2):uint()
    if stop - at < 3 + size then return nil, "a block", at end
    local block
    for _, message in ipairs(BLOCKS) do block = message.number == id and message or block end
    local item = tree:add(tvb(at, 3 + size), "Block: " .. (block and block.name or "unknown"))
    add_rows(item, tvb, at, stop, BLOCK)
    add_body(item, tvb, { message = block, body = at + 3, stop = at + 3 + size, why = "Unknown block" })
    at = at + 3 + size
  end
  return at
end
BY_HAND.TrajectoryData = add_move
BY_HAND.SetTrajectoryData = add_move

-- A HID report is its id, 1, a message, and padding. A message that goes on in the next report is not described anywhere.
local function report(tvb, pinfo, root)
  local data = tvb(1):tvb()
  local what, size = next_frame(data, 0)
  if what ~= "frame" then return false end
  pinfo.cols.protocol = NAME
  pinfo.cols.info = ""
  show_frame(data, pinfo, root, 0, size)
  if data:len() > size then root:add(PADDING, data(size)) end
  return true
end

local function is_report(tvb)
  return tvb:len() == 64 and tvb(0, 2):uint() == 0x0104
end

function proto.dissector(tvb, pinfo, root)
  if is_report(tvb) and report(tvb, pinfo, root) then return tvb:len() end
  return dissect(tvb, pinfo, root)
end

proto.fields, proto.experts = all_fields, E
DissectorTable.get("tcp.port"):add(PORT, proto)
DissectorTable.get("udp.port"):add(PORT, proto)
DissectorTable.get("wtap_encap"):add(wtap_encaps.USER2, proto)
proto:register_heuristic("usb.interrupt", function(tvb, pinfo, root)
  return is_report(tvb) and report(tvb, pinfo, root)
end)
